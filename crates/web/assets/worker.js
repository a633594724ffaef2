// One analysis, once: the page starts a worker for each, and ends it to cancel.
"use strict";
let bug = null;

// called by the program before a bug ends it
function panicked(text) { bug = text; }

self.onmessage = ({ data: { module, files, options, what } }) => {
  const say = (message) => self.postMessage({ what, ...message });
  try {
    wasm_bindgen.initSync({ module });
    const given = new wasm_bindgen.Files();
    for (const { name, bytes } of files) given.add(name, bytes);
    const analysis = given.read(JSON.stringify(options));
    say({ remarks: analysis.remarks(), samples: analysis.samples() });
    let last = 0;
    const progress = (share, doing) => {
      // a step of the search takes milliseconds; the eye needs less
      if (performance.now() - last > 50) { last = performance.now(); say({ share, doing }); }
    };
    say({ answer: what === "identify" ? analysis.identify() : analysis.diagnose(progress) });
  } catch (error) {
    // what is refused is a plain Error; a trap, or memory that is not enough, has a type of its own
    if (bug === null && error.constructor === Error) say({ refused: error.message });
    else say({ bug: bug ?? `${error.name}: ${error.message}; was the memory of the browser enough?` });
  }
};
