"use strict";
// The page's own script: reads the numbers that lie in it, and lets Plotly draw them. Nothing is loaded from anywhere.
(() => {
  const D = JSON.parse(document.getElementById("data").textContent);
  const by = id => document.getElementById(id);
  const P = D.palette, colour = name => D.colours[D.methods.indexOf(name)];
  const CONFIG = { responsive: true, displaylogo: false, scrollZoom: true, plotlyServerURL: "", // named, so that no new one sends the plot away
    modeBarButtons: [["zoom2d", "pan2d", "resetScale2d", "toImage"]] };
  const NEIGHBOURS = 2; // lines of the file that a point's own line may be off by
  const FAR = [1.5, 8]; // mm shown around a corner, and at least 15 times its error

  // ---- numbers ----
  const KINDS = { i4: Int32Array, i2: Int16Array, u2: Uint16Array };
  function unpacked(text, kind) {
    const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
    return new KINDS[kind](bytes.buffer);
  }
  function path(packed) { // a thinned path: mm, um, lines of the file, and where no line leads to
    return { x: Array.from(unpacked(packed.x, "i4"), v => v / 1000), y: Array.from(unpacked(packed.y, "i4"), v => v / 1000),
      error: unpacked(packed.error, "u2"), line: unpacked(packed.line, "i4"), fresh: new Set(unpacked(packed.new, "i4")) };
  }
  D.corners.forEach(corner => Object.values(corner.windows).forEach(one => { // mm and um, from whole um and tenths of them
    const list = (packed, kind, unit) => Array.from(unpacked(packed, kind), v => v / unit);
    const desired = one.desired.map(each => list(each, "i4", 1e4)), off = one.off.map(each => list(each, "i2", 1e3));
    Object.assign(one, { along: list(one.along, "i4", 1e3), error: list(one.error, "i2", 10), desired,
      nozzle: desired.map((each, axis) => each.map((v, i) => v + off[axis][i])) });
  }));
  const asPath = (xy, error) => ({ x: xy[0], y: xy[1], error, line: null, fresh: new Set([0]) });

  // ---- what all plots share ----
  const axis = (title, more) => Object.assign({ title: { text: title, standoff: 8 }, gridcolor: P.grid, zeroline: false,
    linecolor: P.desired, ticks: "outside", tickcolor: P.desired, automargin: true }, more);
  const layout = (x, y, more) => Object.assign({ margin: { l: 60, r: 40, t: 10, b: 44 }, modebar: { orientation: "v", bgcolor: "rgba(255,255,255,0)" }, paper_bgcolor: "#fff", plot_bgcolor: "#fff",
    font: { family: "system-ui, 'Segoe UI', Roboto, 'Helvetica Neue', 'DejaVu Sans', sans-serif", size: 13, color: P.ink },
    legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom", bgcolor: "rgba(255,255,255,0.8)" }, hovermode: "closest", xaxis: x, yaxis: y }, more);
  const faded = (hex, alpha) => `rgba(${[1, 3, 5].map(i => parseInt(hex.slice(i, i + 2), 16)).join()},${alpha})`;
  const draw = (id, traces, how) => Plotly.react(id, traces, how, CONFIG);
  const section = (name, shown) => { if (!shown) document.querySelector(`section[data-plot=${name}]`).remove(); return shown; };
  const some = many => Object.values(many).some(one => one && (!Array.isArray(one) || one.some(Boolean)));

  // ---- a layer from above ----
  const state = { layer: 0, colour: "", corner: null, times: 1 };

  function line(one, name, style, more) { // one path as one line, broken where runs begin
    const x = [], y = [], told = [];
    for (let i = 0; i < one.x.length; i++) {
      if (i && one.fresh.has(i)) { x.push(null); y.push(null); told.push(null); }
      x.push(one.x[i]); y.push(one.y[i]);
      told.push((one.line ? `line ${one.line[i]}<br>` : "") + (one.error ? `${Math.abs(Math.round(one.error[i]))} µm off` : "desired"));
    }
    return Object.assign({ type: "scatter", mode: "lines", x, y, text: told, name, line: style,
      hovertemplate: `X %{x:.3f} Y %{y:.3f}<br>%{text}<extra>${name}</extra>` }, more);
  }

  function classes(one, legend) { // one path as a line for each class of error
    const edges = [...P.steps, Infinity];
    const lines = edges.map(() => ({ x: [], y: [], text: [], last: -1 }));
    for (let i = 1; i < one.x.length; i++) {
      if (one.fresh.has(i)) continue;
      const worst = Math.max(Math.abs(one.error[i - 1]), Math.abs(one.error[i]));
      const into = lines[edges.findIndex(edge => worst <= edge)];
      for (const j of into.last === i - 1 ? [i] : [i - 1, i]) {
        if (j === i - 1 && into.x.length) { into.x.push(null); into.y.push(null); into.text.push(null); }
        into.x.push(one.x[j]); into.y.push(one.y[j]);
        into.text.push((one.line ? `line ${one.line[j]}<br>` : "") + `${Math.abs(Math.round(one.error[j]))} µm off`);
      }
      into.last = i;
    }
    return lines.map((each, k) => ({ type: "scatter", mode: "lines", x: each.x, y: each.y, text: each.text,
      name: k < P.steps.length ? `≤ ${P.steps[k]} µm` : `> ${P.steps[k - 1]} µm`, legendgroup: "class" + k, showlegend: legend,
      line: { color: P.errors[k], width: 2.2 }, hovertemplate: "X %{x:.3f} Y %{y:.3f}<br>%{text}<extra></extra>" }));
  }

  function magnified(one, desired) { // each point as many times as far from the nearest point of the path that its lines ask for
    if (state.times === 1 || !desired.line || !one.line) return one;
    const x = [], y = [], n = desired.line.length;
    let first = 0;
    for (let i = 0; i < one.x.length; i++) {
      while (first < n - 1 && desired.line[first + 1] < one.line[i] - NEIGHBOURS) first++;
      let best = Infinity, dx = 0, dy = 0;
      for (let k = first; k < n - 1 && desired.line[k] <= one.line[i] + NEIGHBOURS; k++) {
        if (desired.fresh.has(k + 1)) continue;
        const ax = one.x[i] - desired.x[k], ay = one.y[i] - desired.y[k], sx = desired.x[k + 1] - desired.x[k], sy = desired.y[k + 1] - desired.y[k];
        const share = Math.min(1, Math.max(0, (ax * sx + ay * sy) / (sx * sx + sy * sy || 1))), gx = ax - share * sx, gy = ay - share * sy;
        if (gx * gx + gy * gy < best) { best = gx * gx + gy * gy; dx = gx; dy = gy; }
      }
      x.push(one.x[i] + (state.times - 1) * dx);
      y.push(one.y[i] + (state.times - 1) * dy);
    }
    return Object.assign({}, one, { x, y });
  }

  function drawPlan() {
    const layer = D.layers[state.layer], corner = state.corner === null ? null : D.corners[state.corner], traces = [];
    const here = !corner || (layer && layer.number === corner.layer);
    const shown = state.colour ? [state.colour] : D.methods, desired = layer ? path(layer.desired) : null;
    if (layer && here) traces.push(line(desired, "desired path", { color: faded(P.desired, 0.55), width: state.colour ? 1 : 5 },
      { hoverinfo: "skip", hovertemplate: null }));
    for (const name of shown) {
      const paths = layer && here && layer.nozzle[name] ? [magnified(path(layer.nozzle[name]), desired)] : [];
      if (!here && corner.windows[name]) paths.push(asPath(corner.windows[name].nozzle, corner.windows[name].error));
      paths.forEach((one, i) => traces.push(...(state.colour ? classes(one, i === 0) : [line(one, name, { color: colour(name), width: 1.6 })])));
    }
    if (!here) traces.unshift(line(asPath(corner.windows[corner.method].desired, null), "desired path", { color: faded(P.desired, 0.55), width: 5 }));
    draw("plan", traces, layout(axis("X [mm]"), axis("Y [mm]", { scaleanchor: "x" }), { dragmode: "zoom", uirevision: "plan" }));
    by("layer-told").textContent = layer ? `${layer.number + 1} of ${D.layerCount} at Z ${layer.z.toFixed(2)} mm` : "none";
    const where = corner ? `Line ${corner.line} of the file, layer ${corner.layer + 1}${corner.feature ? ", " + corner.feature : ""}, ` +
      `${corner.time.toFixed(1)} s after the start: ${corner.method} is ${Math.round(corner.error)} µm off.` : "";
    by("plan-note").textContent = where + (here ? "" : " Of this layer only the corner itself is in the page.");
  }

  function drawCorner() {
    const corner = D.corners[state.corner === null ? 0 : state.corner];
    if (!corner) { by("corner").remove(); return; }
    const own = corner.windows[corner.method].along, far = 4 * reach(corner);
    const range = [Math.max(-far, own[0]), Math.min(far, own[own.length - 1])];
    const traces = D.methods.filter(name => corner.windows[name]).map(name => ({ type: "scatter", mode: "lines", name,
      x: corner.windows[name].along, y: corner.windows[name].error, line: { color: colour(name), width: 1.8 },
      hovertemplate: "%{x:.2f} mm, %{y:.0f} µm<extra>" + name + "</extra>" }));
    draw("corner", traces, layout(axis("along the path, from the largest error [mm]", { range }),
      axis("distance from the path, + is left [µm]", { zeroline: true, zerolinecolor: P.desired }),
      { annotations: [{ text: `${Math.round(corner.error)} µm: layer ${corner.layer + 1}, line ${corner.line}`, xref: "paper", yref: "paper", x: 0.99, y: 0.99,
        xanchor: "right", yanchor: "top", showarrow: false, bgcolor: "rgba(255,255,255,0.8)" }] }));
  }

  const reach = corner => Math.min(Math.max(0.015 * corner.error, FAR[0]), FAR[1]);

  function jump(index) {
    const corner = D.corners[index], far = reach(corner), found = D.layers.findIndex(layer => layer.number === corner.layer);
    state.corner = index;
    if (found >= 0) { state.layer = found; by("layer").value = found; }
    drawPlan();
    drawCorner();
    Plotly.relayout("plan", { "xaxis.range": [corner.at[0] - far, corner.at[0] + far], "yaxis.range": [corner.at[1] - far, corner.at[1] + far] });
    mark();
  }

  function whole() {
    state.corner = null;
    drawPlan();
    Plotly.relayout("plan", { "xaxis.autorange": true, "yaxis.autorange": true });
    mark();
  }

  const chips = [];
  const mark = () => chips.forEach((chip, i) => chip.classList.toggle("on", i === state.corner));

  function planControls() {
    const slider = by("layer"), choice = by("colour");
    slider.max = Math.max(0, D.layers.length - 1);
    slider.value = state.layer = Math.floor(D.layers.length / 2);
    slider.oninput = () => { state.layer = Number(slider.value); state.corner = null; mark(); drawPlan(); };
    choice.add(new Option("one for each method", ""));
    D.methods.forEach(name => choice.add(new Option(`by error of ${name}`, name)));
    choice.onchange = () => { state.colour = choice.value; drawPlan(); };
    by("times").onchange = () => { state.times = Number(by("times").value); drawPlan(); };
    by("all").onclick = whole;
    D.methods.forEach(name => {
      const own = D.corners.map((corner, i) => [corner, i]).filter(([corner]) => corner.method === name);
      if (!own.length) return;
      const row = Object.assign(document.createElement("div"), { className: "chips" });
      row.append(Object.assign(document.createElement("b"), { textContent: `Worst of ${name} [µm]` }));
      for (const feature of new Set(own.map(([corner]) => corner.feature))) {
        row.append(Object.assign(document.createElement("span"), { textContent: feature }));
        own.filter(([corner]) => corner.feature === feature).forEach(([corner, i]) => {
          chips[i] = Object.assign(document.createElement("button"), { type: "button", textContent: Math.round(corner.error),
            title: `layer ${corner.layer + 1}, line ${corner.line}`, onclick: () => jump(i) });
          row.append(chips[i]);
        });
      }
      by("chips").append(row);
    });
  }

  // ---- curves ----
  const long = Math.max(...Object.values(D.errors).map(one => one.begin.length ? one.begin[one.begin.length - 1] : 0)) > 180;
  const clock = begin => begin.map(t => long ? t / 60 : t), CLOCK = long ? "time [min]" : "time [s]";

  function shaded(name, envelope, unit) {
    const x = clock(envelope.begin);
    return [{ type: "scatter", mode: "lines", x, y: envelope.high, name: name + ", largest", legendgroup: name, showlegend: false,
      line: { width: 0.5, color: faded(colour(name), 0.35) }, fill: "tozeroy", fillcolor: faded(colour(name), 0.12), hovertemplate: `%{y:.1f} ${unit} at most<extra>${name}</extra>` },
    { type: "scatter", mode: "lines", x, y: envelope.rms, name, legendgroup: name, line: { width: 1.4, color: colour(name) },
      hovertemplate: `%{y:.1f} ${unit} RMS<extra>${name}</extra>` }];
  }

  const flat = (value, name) => value === null || value === undefined ? [] : [{ type: "scatter", mode: "lines", x: [0, 1], y: [value, value], xaxis: "x2", name,
    line: { color: P.limit, width: 1.2, dash: "dash" }, hovertemplate: `%{y} <extra>${name}</extra>` }];
  const ACROSS = { xaxis2: { overlaying: "x", range: [0, 1], visible: false, fixedrange: true } };

  function drawErrors() {
    draw("errors", D.methods.flatMap(name => shaded(name, D.errors[name], "µm")), layout(axis(CLOCK), axis("µm", { rangemode: "tozero" })));
  }

  function drawParts() {
    if (section("layers", some(D.byLayer))) draw("layers", Object.entries(D.byLayer).flatMap(([name, one]) => [
      { type: "scatter", mode: "lines", x: one.rms.map((_, i) => i + 1), y: one.rms, name, legendgroup: name, line: { color: colour(name), width: 1.8 }, hovertemplate: "layer %{x}: %{y:.1f} µm RMS<extra>" + name + "</extra>" },
      { type: "scatter", mode: "lines", x: one.rms.map((_, i) => i + 1), y: one.largest, name: name + ", largest", legendgroup: name, showlegend: false, line: { color: faded(colour(name), 0.45), width: 0.8 }, hovertemplate: "layer %{x}: %{y:.0f} µm at most<extra>" + name + "</extra>" }]),
    layout(axis("layer"), axis("µm", { rangemode: "tozero" })));
    if (section("features", some(D.byFeature))) {
      const seen = D.features.map((_, i) => i).filter(i => Object.values(D.byFeature).some(one => one.rms[i] !== null));
      draw("features", Object.entries(D.byFeature).map(([name, one]) => ({ type: "bar", name, x: seen.map(i => D.features[i]), y: seen.map(i => one.rms[i]),
        marker: { color: colour(name) }, hovertemplate: "%{x}: %{y:.1f} µm RMS<extra>" + name + "</extra>" })), layout(axis(""), axis("µm RMS"), { barmode: "group", bargap: 0.35 }));
    }
  }

  const WALL = 30; // mm of it that are shown at first
  function drawFaces() {
    if (!section("faces", D.faces.length)) return;
    D.faces.forEach((face, k) => {
      const names = Object.keys(face.off), steepest = Math.max(20, ...names.flatMap(name => face.slope[name].map(Math.abs)));
      const longest = Math.max(...names.map(name => face.along[name][face.along[name].length - 1]));
      const plot = Object.assign(document.createElement("div"), { id: "face-" + k, className: "plot" });
      plot.style.height = `${290 + 34 * names.length}px`;
      by("faces").append(plot);
      const share = 34 * names.length / (230 + 34 * names.length);
      draw(plot.id, names.flatMap((name, i) => [
        { type: "scatter", mode: "lines", x: face.along[name], y: face.off[name], name, line: { color: colour(name), width: 1.8 }, hovertemplate: "%{x:.1f} mm: %{y:.0f} µm<extra>" + name + "</extra>" },
        { type: "heatmap", x: face.along[name], y: [i], z: [face.slope[name]], yaxis: "y2", zmin: -steepest, zmax: steepest, colorscale: "Greys", showscale: false, hoverinfo: "skip" }]),
      layout(axis(`along the wall [mm]: ${face.name}`, { anchor: "y2", range: [0, Math.min(WALL, longest)] }), axis("off the path [µm]", { domain: [share + 0.03, 1] }),
        { yaxis2: { domain: [0, share], tickvals: names.map((_, i) => i), ticktext: names, autorange: "reversed", automargin: true, fixedrange: true } }));
    });
  }

  const HZ = [2, 5, 10, 20, 50, 100, 200], TIMES = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100];
  function drawBode() {
    if (!section("bode", D.plants.length || some(D.asked))) return;
    ["x", "y"].forEach((id, i) => {
      const rows = [];
      if (D.plants[i]) rows.push(["model of the machine", D.plants[i], { color: P.limit, width: 1.2, dash: "dot" }]);
      D.methods.forEach(name => {
        if (D.asked[name][i] && D.asked[name][i].magnitude.some(m => Math.abs(m - 1) > 0.02)) rows.push([`${name}: compensator`, D.asked[name][i], { color: faded(colour(name), 0.75), width: 1.4, dash: "dash" }]);
        if (D.reached[name][i]) rows.push([`${name}: product`, D.reached[name][i], { color: colour(name), width: 2 }]);
      });
      draw("bode-" + id, rows.flatMap(([name, one, style]) => [
        { type: "scatter", mode: "lines", x: one.frequency, y: one.magnitude, name, legendgroup: name, line: style, hovertemplate: "%{x:.1f} Hz: %{y:.2f}×<extra>" + name + "</extra>" },
        { type: "scatter", mode: "lines", x: one.frequency, y: one.phase, yaxis: "y2", name, legendgroup: name, showlegend: false, line: style, hovertemplate: "%{x:.1f} Hz: %{y:.0f}°<extra>" + name + "</extra>" }]),
      layout(axis(`frequency [Hz], axis ${id.toUpperCase()}`, { type: "log", anchor: "y2", range: [Math.log10(2), Math.log10(200)], tickvals: HZ }), axis("magnitude", { type: "log", domain: [0.42, 1], tickvals: TIMES }), { yaxis2: axis("phase [°]", { domain: [0, 0.34] }) }));
    });
  }

  function drawMoves() {
    [["speed", 0, "mm/s", "velocity"], ["acceleration", 2, "mm/s²", "acceleration"]].forEach(([id, first, unit, kind]) => {
      const traces = D.methods.flatMap(name => [0, 1].map(i => ({ type: "scatter", mode: "lines", x: clock(D.moves[name].begin), y: D.moves[name].size[first + i],
        name: `${name}, ${"XY"[i]}`, line: { color: colour(name), width: 1.1, dash: i ? "dot" : "solid" }, hovertemplate: `%{y:.0f} ${unit}<extra>${name}, ${"XY"[i]}</extra>` })));
      const limits = D.ceilings[kind];
      const told = limits[0] === limits[1] ? flat(limits[0], "limit") : limits.flatMap((limit, i) => flat(limit, `limit of ${"XY"[i]}`));
      draw(id, [...traces, ...told], layout(axis(CLOCK), axis(`${id} [${unit}]`, { rangemode: "tozero" }), ACROSS));
    });
  }

  function drawLoads() {
    if (section("load", some(D.load))) draw("load", [...D.methods.filter(name => D.load[name]).flatMap(name => D.motors.map((motor, i) => ({ type: "scatter", mode: "lines",
      x: clock(D.load[name].begin), y: D.load[name].size[i], name: `${name}, motor ${motor}`, line: { color: colour(name), width: 1.2, dash: ["solid", "dot", "dash"][i % 3] },
      hovertemplate: `%{y:.0f} %<extra>${name}, motor ${motor}</extra>` }))), ...flat(100, "all it has")], layout(axis(CLOCK), axis("% of the torque", { rangemode: "tozero" }), ACROSS));
    if (section("segments", some(D.segments))) draw("segments", [...D.methods.filter(name => D.segments[name]).flatMap(name => shaded(name, D.segments[name], "segments/s")),
      ...flat(D.ceilings.segments, "the firmware takes")], layout(axis(CLOCK), axis("segments per second", { rangemode: "tozero" }), ACROSS));
  }

  planControls();
  drawPlan();
  drawCorner();
  if (D.corners.length) mark();
  drawErrors();
  drawFaces();
  drawParts();
  drawBode();
  drawMoves();
  drawLoads();
  document.body.dataset.ready = "yes";
})();
