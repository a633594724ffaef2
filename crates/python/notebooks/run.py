"""Runs the notebooks; each must end without an error. `python run.py [OUT_DIR]` keeps them with their output."""

import pathlib
import sys
import time

import nbformat
from nbclient import NotebookClient

here = pathlib.Path(__file__).parent
out = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else None
for path in sorted(here.glob("*.ipynb")):
    began = time.monotonic()
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    NotebookClient(notebook, timeout=240, kernel_name="python3", resources={"metadata": {"path": here}}).execute()
    shown = [o for c in notebook.cells for o in c.get("outputs", [])]
    pictures = sum("image/png" in o.get("data", {}) for o in shown)
    pages = sum("<iframe srcdoc" in o.get("data", {}).get("text/html", "") for o in shown)
    print(f"{path.name}: {len(notebook.cells)} cells, {pictures} pictures, {pages} reports, {time.monotonic() - began:.1f} s")
    assert pictures and pages, f"{path.name} shows no picture or no report"
    if out:
        nbformat.write(notebook, out / path.name)
