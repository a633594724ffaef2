// Draws the charts of a tribos report from the JSON in #figures. Colours are read from the page's CSS at
// each drawing, so that light, dark and print show the same chart in their own ink.
(function () {
  "use strict";
  var specs = JSON.parse(document.getElementById("figures").textContent);
  var charts = [];

  function colour(name) {
    return getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
  }

  // At most five significant digits, a real minus sign, powers of ten where a plain number would be long.
  function show(v) {
    if (v === null || v === undefined || !isFinite(v)) return "–";
    var a = Math.abs(v);
    var s = a !== 0 && (a < 1e-3 || a >= 1e5) ? v.toExponential(2) : String(+v.toPrecision(4));
    return s.replace("-", "−");
  }

  // Ticks share one number of decimals; tiny ranges are labelled in powers of ten.
  function ticks(u, values) {
    if (!values.length) return values;
    var top = Math.max.apply(null, values.map(Math.abs));
    if (top !== 0 && (top < 1e-3 || top >= 1e5)) {
      return values.map(function (v) { return v === 0 ? "0" : v.toExponential(1).replace(/-/g, "−"); });
    }
    var step = values.length > 1 ? Math.abs(values[1] - values[0]) : top || 1;
    var decimals = 0;
    while (decimals < 6 && Math.abs(step * Math.pow(10, decimals) - Math.round(step * Math.pow(10, decimals))) > 1e-6) decimals++;
    return values.map(function (v) { return v.toFixed(decimals).replace("-", "−"); });
  }

  // uPlot's own logarithmic axis takes whole decades, and fails on some spans
  var logarithmic = { time: false, distr: 100, fwd: Math.log10, bwd: function (v) { return Math.pow(10, v); },
    range: function (u, lo, hi) { return [lo, hi]; } };

  function decades(u, axis, lo, hi) {
    var splits = [], narrow = hi < 100 * lo;
    for (var exponent = Math.floor(Math.log10(lo)); Math.pow(10, exponent) <= hi; exponent++) {
      (narrow ? [1, 2, 5] : [1]).forEach(function (d) {
        var v = Number(d + "e" + exponent);
        if (v >= lo && v <= hi) splits.push(v);
      });
    }
    return splits;
  }

  function powers(u, values) {
    return values.map(function (v) {
      // uPlot passes null for a label it has no room for
      if (v === null) return null;
      return v >= .01 && v < 1e4 ? String(v) : v.toExponential(0).replace(/-/g, "−").replace("+", "");
    });
  }

  function series(s) {
    var paint = function () { return colour(s.color); };
    var line = { label: s.label, stroke: paint, width: s.width, spanGaps: s.span_gaps };
    if (s.dash) line.dash = [5, 4];
    if (s.kind === "points") {
      line.paths = function () { return null; };
      line.points = { show: true, size: s.width, width: 0, fill: paint, stroke: paint };
    } else if (s.kind === "both") {
      line.points = { show: true, size: 5, width: 0, fill: paint, stroke: paint };
    } else if (s.kind === "edge") {
      line.stroke = "transparent";
      line.width = 0;
      line.points = { show: false };
    } else {
      line.points = { show: false };
    }
    return line;
  }

  function height(spec, width) {
    return Math.round(Math.max(150, Math.min(spec.height, width * .72)));
  }

  function build(spec) {
    var host = document.getElementById(spec.id);
    if (!host) return;
    var width = host.clientWidth;
    var readout = document.createElement("div");
    readout.className = "readout";
    var options = {
      width: width,
      height: height(spec, width),
      legend: { show: false },
      padding: [10, 22, 0, 0],
      cursor: {
        y: false,
        sync: spec.sync ? { key: spec.sync, setSeries: false } : undefined,
        drag: { x: true, y: false, setScale: true },
        points: { show: false }
      },
      scales: { x: spec.log ? logarithmic : { time: false }, y: { range: function (u, lo, hi) {
        if (lo === null || !isFinite(lo) || !isFinite(hi)) return [-1, 1];
        if (lo === hi) { var pad = Math.abs(lo) || 1; return [lo - pad, hi + pad]; }
        var room = .06 * (hi - lo);
        return [lo - room, hi + room];
      } } },
      axes: [
        { stroke: function () { return colour("soft"); }, grid: { stroke: function () { return colour("grid"); }, width: 1 },
          ticks: { show: false }, splits: spec.log ? decades : undefined, values: spec.log ? powers : ticks, label: spec.x, labelSize: 22, size: 30, space: 62, font: "12px system-ui, sans-serif",
          labelFont: "12.5px system-ui, sans-serif" },
        { stroke: function () { return colour("soft"); }, grid: { stroke: function () { return colour("grid"); }, width: 1 },
          ticks: { show: false }, values: ticks, size: 54, space: 34, font: "12px system-ui, sans-serif" }
      ],
      series: [{ label: spec.x }].concat(spec.series.map(series)),
      bands: spec.bands.map(function (b) { return { series: b, fill: function () { return colour("band"); } }; }),
      hooks: {
        drawClear: [function (u) {
          var ctx = u.ctx, box = u.bbox;
          ctx.save();
          ctx.beginPath();
          ctx.rect(box.left, box.top, box.width, box.height);
          ctx.clip();
          ctx.fillStyle = colour("where");
          spec.regions.forEach(function (r) {
            // a logarithmic axis has no zero
            var least = spec.log ? u.scales.x.min : r[0];
            var from = u.valToPos(Math.max(r[0], least), "x", true), to = u.valToPos(Math.max(r[1], least), "x", true);
            ctx.fillRect(from, box.top, Math.max(to - from, 2 * devicePixelRatio), box.height);
          });
          ctx.restore();
        }],
        drawAxes: [function (u) {
          var s = u.scales.y;
          if (!(s.min < 0 && s.max > 0)) return;
          var y = u.valToPos(0, "y", true);
          u.ctx.save();
          u.ctx.strokeStyle = colour("faint");
          u.ctx.lineWidth = devicePixelRatio;
          u.ctx.beginPath();
          u.ctx.moveTo(u.bbox.left, y);
          u.ctx.lineTo(u.bbox.left + u.bbox.width, y);
          u.ctx.stroke();
          u.ctx.restore();
        }],
        setCursor: [function (u) {
          var i = u.cursor.idx;
          if (i === null || i === undefined) { readout.textContent = ""; return; }
          var parts = [spec.x + " " + show(u.data[0][i])];
          spec.series.forEach(function (s, k) {
            if (s.kind !== "edge" && u.data[k + 1][i] !== null) parts.push(s.label + " " + show(u.data[k + 1][i]));
          });
          readout.textContent = parts.join("   ·   ");
        }]
      }
    };
    var chart = new uPlot(options, spec.data, host);
    host.appendChild(readout);
    charts.push({ chart: chart, host: host, spec: spec });
  }

  function resize() {
    charts.forEach(function (c) {
      var w = c.host.clientWidth;
      if (w && w !== c.chart.width) c.chart.setSize({ width: w, height: height(c.spec, w) });
    });
  }

  function redraw() {
    charts.forEach(function (c) { c.chart.redraw(false, true); });
  }

  specs.forEach(build);
  window.addEventListener("resize", resize);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  window.addEventListener("beforeprint", function () {
    document.documentElement.setAttribute("data-theme", "print");
    redraw();
  });
  window.addEventListener("afterprint", function () {
    document.documentElement.removeAttribute("data-theme");
    redraw();
  });
})();
