// Players: frames of a run, unpacked when first scrolled to, drawn by Plotly.
"use strict";
(() => {
  document.documentElement.classList.add("js");
  const SECONDS = 12;  // a whole motion at speed 1
  const byId = id => document.getElementById(id);

  async function unpack(text) {
    const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).arrayBuffer();
  }

  let library;
  function plotly() {
    library ??= unpack(byId("plotly").textContent).then(buffer => {
      const script = document.createElement("script");
      script.textContent = new TextDecoder().decode(buffer);
      document.head.append(script);
      return window.Plotly;
    });
    return library;
  }

  function edgesOf(quads) {
    const seen = new Map();
    for (let e = 0; e < quads.length; e += 4)
      for (let k = 0; k < 4; k++) {
        const a = quads[e + k], b = quads[e + (k + 1) % 4];
        seen.set(Math.min(a, b) * 65536 + Math.max(a, b), [a, b]);
      }
    return [...seen.values()];
  }

  function trianglesOf(quads) {
    const [i, j, k] = [[], [], []];
    for (let e = 0; e < quads.length; e += 4) {
      i.push(quads[e], quads[e]);
      j.push(quads[e + 1], quads[e + 2]);
      k.push(quads[e + 2], quads[e + 3]);
    }
    return {i, j, k};
  }

  async function load(name) {
    const d = JSON.parse(byId("data-" + name).textContent);
    d.position = new Uint16Array(await unpack(d.position));
    d.density = new Uint8Array(await unpack(d.density));
    d.quads = new Uint16Array(await unpack(d.quads));
    d.edges = edgesOf(d.quads);
    return d;
  }

  // Coordinates of the nodes of a frame, about the centre of area, or in space.
  function nodesAt(d, frame, follow) {
    return [0, 1, 2].map(axis => {
      const shift = d.low[axis] + (follow ? 0 : d.centre[axis][frame]);
      const out = new Float32Array(d.nodes);
      for (let n = 0; n < d.nodes; n++)
        out[n] = shift + d.position[3 * (frame * d.nodes + n) + axis] * d.size / d.steps;
      return out;
    });
  }

  function linesAt(d, [x, y, z]) {
    return [x, y, z].map(of => {
      const out = new Float32Array(3 * d.edges.length).fill(NaN);
      d.edges.forEach(([a, b], k) => { out[3 * k] = of[a]; out[3 * k + 1] = of[b]; });
      return out;
    });
  }

  function densityAt(d, frame) {
    const out = new Float32Array(2 * d.elements);
    for (let e = 0; e < d.elements; e++)
      out[2 * e] = out[2 * e + 1] = d.density[frame * d.elements + e] / d.colours * d.top;
    return out;
  }

  function scene(d, follow) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let frame = 0; frame < d.frames; frame++)
      nodesAt(d, frame, follow).forEach((values, axis) => values.forEach(v => {
        low[axis] = Math.min(low[axis], v);
        high[axis] = Math.max(high[axis], v);
      }));
    const span = high.map((h, axis) => h - low[axis]), largest = Math.max(...span);
    const half = span.map(s => Math.max(s, 0.15 * largest) * 0.53);
    const axis = k => ({
      range: [(low[k] + high[k]) / 2 - half[k], (low[k] + high[k]) / 2 + half[k]],
      title: {text: "xyz"[k] + " [m]", font: {size: 11}}, tickfont: {size: 9}, nticks: 5,
      backgroundcolor: "#fff", gridcolor: "#ddd", zerolinecolor: "#ccc", showspikes: false});
    const most = Math.max(...half);
    const [x, y, z] = half.map(h => 1.35 * h / most);
    return {xaxis: axis(0), yaxis: axis(1), zaxis: axis(2), aspectmode: "manual",
      aspectratio: {x, y, z}, uirevision: String(follow), dragmode: "orbit",
      camera: {eye: {x: 1.15, y: -1.25, z: 0.85}, projection: {type: "orthographic"}}};
  }

  function traces(d) {
    const nodes = nodesAt(d, 0, true), lines = linesAt(d, nodes);
    const lit = {ambient: 0.85, diffuse: 0.35, specular: 0.05, roughness: 0.9};
    return [
      {type: "mesh3d", x: nodes[0], y: nodes[1], z: nodes[2], ...trianglesOf(d.quads),
        intensity: densityAt(d, 0), intensitymode: "cell", cmin: 0, cmax: d.top,
        colorscale: d.scale, flatshading: true, lighting: lit, hoverinfo: "skip",
        colorbar: {title: {text: "strain energy<br>density [J/m²]", font: {size: 11}},
          thickness: 10, len: 0.7, tickfont: {size: 10}, x: 1, xpad: 2}},
      {type: "scatter3d", mode: "lines", x: lines[0], y: lines[1], z: lines[2],
        line: {color: "#4a4f57", width: 1}, hoverinfo: "skip", showlegend: false}];
  }

  async function start(root) {
    const part = name => root.querySelector("." + name);
    const stage = part("stage"), button = part("play"), slider = part("time");
    const [Plotly, d] = await Promise.all([plotly(), load(root.dataset.case)]);
    const layout = {scene: scene(d, true), margin: {l: 0, r: 0, t: 0, b: 0}, autosize: true,
      paper_bgcolor: "rgba(0,0,0,0)", font: {family: "DejaVu Sans, Verdana, sans-serif", color: "#222"}};
    await Plotly.newPlot(stage, traces(d), layout,
      {responsive: true, displaylogo: false, displayModeBar: false, scrollZoom: false});
    const most = Math.max(...d.kinetic.map((value, k) => value + d.strain[k]));
    const joules = (value, digits) => (value > 1e-12 * most ? value : 0).toPrecision(digits);
    let frame = 0, playing = false, held = false, drawing = false, follow = true, clock, place = 0, ready = 0;

    async function show(k) {
      frame = k;
      slider.value = k;
      part("now").value = d.times[k].toPrecision(3) + " s";
      for (const kind of ["kinetic", "strain"]) {
        root.querySelector(`.energy .${kind}`).style.width = 100 * d[kind][k] / most + "%";
        root.querySelector(`.energies .${kind} b`).textContent = joules(d[kind][k], 4);
      }
      root.querySelector(".energies .total b").textContent =
        joules(d.kinetic[k] + d.strain[k], 5);
      const nodes = nodesAt(d, k, follow), lines = linesAt(d, nodes);
      drawing = true;
      const began = performance.now();
      await Plotly.restyle(stage, {x: [nodes[0], lines[0]], y: [nodes[1], lines[1]],
        z: [nodes[2], lines[2]], intensity: [densityAt(d, k), null]}, [0, 1]);
      drawing = false;
      ready = 2 * performance.now() - began;  // as long again for everything else
      stage.dataset.frame = k;
    }

    function tick(now) {
      if (!playing) return;
      if (!held && !drawing) {
        place += Math.max(0, now - clock) / 1000 / SECONDS * d.frames * Number(part("speed").value);
        place %= d.frames;
        if (Math.floor(place) !== frame && now > ready) show(Math.floor(place));
      }
      clock = now;
      requestAnimationFrame(tick);
    }

    button.addEventListener("click", () => {
      playing = !playing;
      button.textContent = playing ? "❚❚" : "▶";
      button.setAttribute("aria-label", playing ? "pause" : "play");
      clock = performance.now();
      place = frame;
      if (playing) requestAnimationFrame(tick);
    });
    slider.addEventListener("input", () => { place = Number(slider.value); show(place); });
    part("follow").addEventListener("change", async event => {
      follow = event.target.checked;
      await Plotly.relayout(stage, {scene: scene(d, follow)});
      show(frame);
    });
    stage.addEventListener("pointerdown", () => { held = true; });
    addEventListener("pointerup", () => { held = false; });
    await show(0);
    root.classList.add("ready");
  }

  const watcher = new IntersectionObserver(entries => {
    for (const entry of entries)
      if (entry.isIntersecting) {
        watcher.unobserve(entry.target);
        start(entry.target).catch(error => {
          entry.target.querySelector(".stage").textContent = "The player cannot start: " + error;
        });
      }
  }, {rootMargin: "200px"});
  document.querySelectorAll(".player").forEach(root => watcher.observe(root));
})();
