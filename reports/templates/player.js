// Players: frames of a run, unpacked when first scrolled to, drawn by Plotly.
"use strict";
(() => {
  document.documentElement.classList.add("js");
  const SECONDS = 12;  // a whole motion at speed 1
  const FILLED = {true: 0.95, false: 0.75};  // of the stage at zoom 1; axes need room
  const NEAREST = 50, FARTHEST = 0.4, STEP = 1.3;  // zoom
  const AWAY = 50;  // the eye of a parallel projection: outside of all that is zoomed
  const SCROLLING = 300;  // ms in which a wheel that turns the page does not begin to zoom
  let scrolled = -Infinity;
  addEventListener("scroll", () => { scrolled = performance.now(); }, {passive: true});
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

  // Lines or marks of one look of joints and bodies.
  function symbolAt({points, mark}, of) {
    return of.map(values => {
      if (mark) return Float32Array.from(points, k => values[k]);
      const out = new Float32Array(1.5 * points.length).fill(NaN);
      points.forEach((k, n) => { out[3 * (n >> 1) + n % 2] = values[k]; });
      return out;
    });
  }

  function densityAt(d, frame) {
    const out = new Float32Array(2 * d.elements);
    for (let e = 0; e < d.elements; e++)
      out[2 * e] = out[2 * e + 1] = d.density[frame * d.elements + e] / d.colours * d.top;
    return out;
  }

  // Right and up on the screen of an eye in a direction of unit length, z upwards.
  function screenOf([x, y, z]) {
    const r = Math.hypot(x, y);
    return [[-y / r, x / r, 0], [-z * x / r, -z * y / r, r]];
  }

  // The box of all frames, and how far they reach from its centre along directions.
  function reach(d, follow, directions) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    const all = Array.from({length: d.frames}, (_, frame) => nodesAt(d, frame, follow));
    all.forEach(nodes => nodes.forEach((values, axis) => values.forEach(v => {
      low[axis] = Math.min(low[axis], v);
      high[axis] = Math.max(high[axis], v);
    })));
    const centre = low.map((l, axis) => (l + high[axis]) / 2);
    const far = directions.map(along => {
      let most = 0;
      for (const nodes of all)
        for (let n = 0; n < d.nodes; n++)
          most = Math.max(most, Math.abs(along.reduce(
            (sum, part, axis) => sum + part * (nodes[axis][n] - centre[axis]), 0)));
      return most;
    });
    return {centre, span: high.map((h, axis) => h - low[axis]), far};
  }

  // Axes about all frames, and the scale by which these fill a stage of such a width over height.
  function scene(d, follow, shape) {
    const {centre, span, far} = reach(d, follow, screenOf(d.eye));
    const half = span.map(s => Math.max(s, 0.15 * Math.max(...span)) * 0.53);
    const axis = k => ({
      range: [centre[k] - half[k], centre[k] + half[k]], visible: !follow,
      title: {text: "xyz"[k] + " [m]", font: {size: 11}}, tickfont: {size: 9}, nticks: 5,
      backgroundcolor: "#fff", gridcolor: "#ddd", zerolinecolor: "#ccc", showspikes: false});
    const [x, y, z] = half.map(h => 2 * h * FILLED[follow] * Math.min(shape / far[0], 1 / far[1]));
    return {xaxis: axis(0), yaxis: axis(1), zaxis: axis(2), aspectmode: "manual",
      aspectratio: {x, y, z}, dragmode: "orbit"};
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
        line: {color: "#4a4f57", width: 1}, hoverinfo: "skip", showlegend: false},
      ...d.symbols.map(symbol => {
        const [x, y, z] = symbolAt(symbol, nodes);
        return {type: "scatter3d", mode: symbol.mark ? "markers" : "lines", x, y, z,
          line: {color: symbol.colour, width: 4 * symbol.width},
          marker: {color: symbol.colour, size: symbol.width, symbol: symbol.mark ?? "circle"},
          hoverinfo: "skip", showlegend: false};
      })];
  }

  async function start(root) {
    const part = name => root.querySelector("." + name);
    const stage = part("stage"), button = part("play"), slider = part("time");
    const [Plotly, d] = await Promise.all([plotly(), load(root.dataset.case)]);
    const camera = () => ({eye: {x: AWAY * d.eye[0], y: AWAY * d.eye[1], z: AWAY * d.eye[2]},
      center: {x: 0, y: 0, z: 0}, up: {x: 0, y: 0, z: 1}, projection: {type: "orthographic"}});
    const shape = () => stage._fullLayout._size.w / stage._fullLayout._size.h;
    const layout = {scene: {...scene(d, true, 1), camera: camera()}, uirevision: "kept", margin: {l: 0, r: 0, t: 0, b: 0}, autosize: true,
      paper_bgcolor: "rgba(0,0,0,0)", font: {family: "DejaVu Sans, Verdana, sans-serif", color: "#222"}};
    await Plotly.newPlot(stage, traces(d), layout,
      {responsive: true, displaylogo: false, displayModeBar: false, scrollZoom: false});
    const most = Math.max(...d.kinetic.map((value, k) => value + d.strain[k]));
    const joules = (value, digits) => (value > 1e-12 * most ? value : 0).toPrecision(digits);
    let frame = 0, playing = false, held = false, drawing = false, clock, place = 0, ready = 0;
    let follow = true, zoom = 1, plain = scene(d, follow, shape()), turning = false;

    // The scene at this zoom, seen as it is or by another camera.
    function look(from) {
      const {x, y, z} = plain.aspectratio;
      stage.dataset.zoom = zoom;
      return Plotly.relayout(stage, {scene: {...plain, camera: from ?? stage.layout.scene.camera,
        aspectratio: {x: zoom * x, y: zoom * y, z: zoom * z}}});
    }

    function nearer(factor) {
      zoom = Math.min(NEAREST, Math.max(FARTHEST, zoom * factor));
      if (turning) return;
      turning = true;
      requestAnimationFrame(() => { turning = false; look(); });
    }

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
      const all = [nodes, lines, ...d.symbols.map(symbol => symbolAt(symbol, nodes))];
      await Plotly.restyle(stage, {x: all.map(of => of[0]), y: all.map(of => of[1]),
        z: all.map(of => of[2]), intensity: all.map((_, n) => n ? null : densityAt(d, k))},
        all.map((_, n) => n));
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

    function play(on) {
      playing = on;
      button.textContent = playing ? "❚❚" : "▶";
      button.setAttribute("aria-label", playing ? "pause" : "play");
      clock = performance.now();
      place = frame;
      if (playing) requestAnimationFrame(tick);
    }

    button.addEventListener("click", () => play(!playing));
    slider.addEventListener("input", () => { place = Number(slider.value); show(place); });
    part("follow").addEventListener("change", async event => {
      follow = event.target.checked;
      plain = scene(d, follow, shape());
      await look();
      show(frame);
    });
    part("nearer").addEventListener("click", () => nearer(STEP));
    part("farther").addEventListener("click", () => nearer(1 / STEP));
    part("whole").addEventListener("click", () => { zoom = 1; look(camera()); });
    stage.addEventListener("wheel", event => {
      if (performance.now() - scrolled < SCROLLING && !event.ctrlKey) return;
      event.preventDefault();
      nearer(Math.exp(-0.0015 * event.deltaY * (event.deltaMode ? 30 : 1) * (event.ctrlKey ? 6 : 1)));
    }, {passive: false});
    let apart = null;  // two fingers
    const fingers = event => {
      const [a, b] = event.touches;
      const now = b ? Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY) : null;
      if (now && apart) nearer(now / apart);
      apart = now;
      if (b) { event.preventDefault(); event.stopPropagation(); }
    };
    for (const kind of ["touchstart", "touchmove", "touchend", "touchcancel"])
      stage.addEventListener(kind, fingers, {capture: true, passive: false});
    root.addEventListener("keydown", event => {
      const at = event.target, step = {ArrowLeft: -1, ArrowRight: 1}[event.key];
      if (event.ctrlKey || event.altKey || event.metaKey || at.matches("select")) return;
      if (event.key === " " && !at.matches("button, [type=checkbox]")) play(!playing);
      else if (step && at !== slider) {
        play(false);
        show((frame + step + d.frames) % d.frames);
      } else if (event.key === "+" || event.key === "-") nearer(STEP ** (event.key + 1));
      else return;
      event.preventDefault();
    });
    stage.addEventListener("pointerdown", () => {
      held = true;
      root.focus({preventScroll: true});
    }, {capture: true});
    addEventListener("pointerup", () => { held = false; });
    addEventListener("pointercancel", () => { held = false; });
    await look(camera());
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
