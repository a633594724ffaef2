// Takes files, asks two workers for an identification and a diagnosis, shows and saves what they answer.
"use strict";
(() => {
  const $ = (selector) => document.querySelector(selector);
  const text = (id) => document.getElementById(id).textContent;
  const form = $("#options");
  const KINDS = {
    diagnose: { tab: $("#tab-diagnosis"), file: "diagnosis", command: "diagnose", fails: "No diagnosis" },
    identify: { tab: $("#tab-identification"), file: "identification", command: "identify", fails: "No identification" },
  };
  const EXAMPLE = {
    name: "tribometer.csv",
    map: "time_s=time_s,position_m=0.001*stroke_mm,force_n=friction_n,normal_force_n=load_n",
  };
  let files = [];
  let workers = [];
  let answers = {};
  let shown = null;
  let byHand = false; // a report that somebody chose is not taken away
  let commands = {}; // as they were when the work began
  let turn = 0;

  // the program: base64 of a deflated module
  const program = (async () => {
    const packed = Uint8Array.from(atob(text("module")), (c) => c.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    return WebAssembly.compile(await new Response(stream).arrayBuffer());
  })();
  program.catch(() => {});
  const workerUrl = URL.createObjectURL(new Blob([text("worker")], { type: "text/javascript" }));

  function element(tag, className, content) {
    const made = document.createElement(tag);
    made.className = className;
    made.append(content);
    return made;
  }

  function say(className, content) { $("#said").append(element("p", className, content)); }

  // A refusal: one line, and below it what to do.
  function refuse(content) {
    const [message, help] = content.split("\n  help: ");
    say("refused", message);
    if (help) say("help", help);
    if (/no column|no variable|no header|map, column/.test(message)) {
      say("help", "Say below which columns are time, position and force, then press Analyse.");
      document.body.classList.add("foreign");
      $("#settings").open = true;
    }
  }

  function stop() {
    turn += 1;
    for (const worker of workers) worker.terminate();
    workers = [];
    $("#work").hidden = true;
    $("#run").disabled = files.length === 0;
  }

  function options() {
    const given = {};
    for (const field of ["law", "cutoff", "noise", "joint", "map"]) given[field] = form.elements[field].value.trim();
    return given;
  }

  // The same for a terminal.
  function command(what) {
    const quoted = (word) => (/^[\w./,=:+@-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`);
    const words = ["tribos", KINDS[what].command, ...files.map((file) => quoted(file.name))];
    const given = options();
    for (const map of given.map.split("\n")) if (map.trim()) words.push("--map", quoted(map.trim()));
    if (given.joint) words.push("--joint", quoted(given.joint));
    if (given.cutoff) words.push("--cutoff", quoted(given.cutoff));
    if (what === "identify" && given.law !== "karnopp") words.push("--law", given.law);
    if (what === "diagnose" && given.noise) words.push("--noise", quoted(given.noise));
    return words.join(" ");
  }

  function offer() {
    for (const [name, { tab }] of Object.entries(KINDS)) {
      tab.disabled = !answers[name];
      tab.setAttribute("aria-selected", String(name === shown));
    }
  }

  function show(what) {
    shown = what;
    offer();
    $("#results").hidden = false;
    $("#report").srcdoc = answers[what].html;
    $("#command").textContent = `The same in a terminal: ${commands[what]}`;
    const downloads = $("#downloads");
    for (const link of downloads.children) URL.revokeObjectURL(link.href);
    const { html, json, model } = answers[what];
    const saved = [
      ["Report", `${KINDS[what].file}.html`, html, "text/html"],
      ["JSON", `${KINDS[what].file}.json`, json, "application/json"],
      ["Model", what === "diagnose" ? "found.toml" : "model.toml", model, "text/plain"],
    ];
    downloads.replaceChildren(
      ...saved.filter(([, , content]) => content).map(([label, name, content, type]) => {
        const link = element("a", "", `↓ ${label}`);
        link.download = link.title = name;
        link.href = URL.createObjectURL(new Blob([content], { type }));
        return link;
      }),
    );
  }

  function hear(worker, { what, remarks, samples, share, doing, answer, refused, bug }) {
    if (!workers.includes(worker)) return;
    if (samples !== undefined && what === "diagnose") {
      $("#chosen").textContent = `${files.map((file) => file.name).join(", ")}: ${samples.toLocaleString("en")} samples`;
      for (const remark of remarks) say("remark", remark);
    }
    if (share !== undefined) {
      $("#work progress").value = share;
      $("#doing").textContent = `diagnosing: ${doing}`;
    }
    if (answer) {
      answers[what] = answer;
      if (shown === null || (what === "diagnose" && !byHand)) show(what); else offer();
    }
    if (refused !== undefined && !$("#said").textContent.includes(refused.split("\n")[0])) refuse(refused);
    if (bug !== undefined) {
      say("refused", `A bug in tribos ended the work (${KINDS[what].fails.toLowerCase()}): ${bug}`);
      say("help", "Please report it with the recording.");
    }
    if (answer || refused !== undefined || bug !== undefined) {
      worker.terminate();
      workers = workers.filter((other) => other !== worker);
      if (workers.length === 0) {
        stop();
        const missing = Object.keys(KINDS).filter((kind) => !answers[kind]);
        if (missing.length === 1) say("help", `${KINDS[missing[0]].fails}.`);
        if (shown !== null && !byHand) $("#results").scrollIntoView({ behavior: "smooth" });
      }
    }
  }

  async function run() {
    stop();
    answers = {};
    shown = null;
    byHand = false;
    $("#results").hidden = true;
    $("#said").replaceChildren();
    document.body.classList.remove("foreign");
    if (files.length === 0) return;
    $("#chosen").hidden = false;
    $("#chosen").textContent = files.map((file) => file.name).join(", ");
    $("#work").hidden = false;
    $("#work progress").removeAttribute("value");
    $("#doing").textContent = "reading";
    commands = Object.fromEntries(Object.keys(KINDS).map((what) => [what, command(what)]));
    const asked = turn;
    try {
      const module = await program;
      const contents = await Promise.all(
        files.map(async (file) => ({ name: file.name, bytes: new Uint8Array(await file.arrayBuffer()) })),
      );
      if (asked !== turn) return;
      for (const what of Object.keys(KINDS)) {
        const worker = new Worker(workerUrl);
        workers.push(worker);
        worker.onmessage = ({ data }) => hear(worker, data);
        worker.onerror = (event) => hear(worker, { what, bug: event.message || "the worker did not start" });
        worker.postMessage({ module, files: contents, options: options(), what });
      }
    } catch (error) {
      if (asked !== turn) return;
      stop();
      say("refused", `The files cannot be read, or this browser is too old: ${error.message}`);
    }
  }

  function take(list, map = "") {
    if (list.length === 0) return;
    files = [...list];
    // the map of the example is of no other file
    if (map || form.elements.map.value === EXAMPLE.map) form.elements.map.value = map;
    run();
  }

  $("#files").addEventListener("change", (event) => {
    take(event.target.files);
    event.target.value = ""; // the same file again, once it is changed
  });
  $("#example").addEventListener("click", () => {
    take([new File([text("recording")], EXAMPLE.name)], EXAMPLE.map);
  });
  form.addEventListener("submit", (event) => { event.preventDefault(); run(); });
  $("#cancel").addEventListener("click", () => { stop(); say("remark", "Cancelled."); });
  for (const [what, { tab }] of Object.entries(KINDS)) {
    tab.addEventListener("click", () => { byHand = true; show(what); });
  }

  // what is typed into the columns becomes the map
  $("#columns").addEventListener("input", (event) => {
    if (event.target.name === "map") return;
    const value = (name) => $(`[data-column=${name}]`).value.trim();
    const unit = (name) => $(`[data-unit=${name}]`).selectedOptions[0];
    const position = unit("position").dataset.signal;
    const force = position === "position_rad" ? "torque_nm" : "force_n";
    const entries = [["time_s", "time_s"], ["position", position], ["force", force]]
      .filter(([name]) => value(name))
      .map(([name, signal]) => {
        const factor = unit(name).value;
        return `${signal}=${factor === "1" ? "" : `${factor}*`}${value(name)}`;
      });
    form.elements.map.value = entries.join(",");
  });

  // a file that misses the target must not replace the page
  for (const kind of ["dragenter", "dragover", "dragleave", "drop"]) {
    document.addEventListener(kind, (event) => {
      event.preventDefault();
      document.body.classList.toggle("over", kind === "dragenter" || kind === "dragover");
      if (kind === "drop") take(event.dataTransfer.files);
    });
  }
})();
