"use strict";
// The explorer: linked pictures of what was measured. The data is in #report (payload.py); the figures on the page are
// written without this script.
(() => {
  const report = JSON.parse(document.getElementById("report").textContent);
  const at = (id) => document.getElementById(id);
  const TRUTH = "truth";
  const MOST_ZOOM = 64; // picture pixels fill so many times the space that they fill in the whole picture
  const KEY_STEP = 0.1; // of what is in view, per arrow key
  const DIVIDER_REACH = 12; // CSS pixels around the divider in which it is grabbed
  const STEPS_OF_TEN = 20; // of the amplification's range, from 1 to 1000

  const state = {
    picture: 0, light: 0, mode: "side", layer: "visibility", left: 0, right: TRUTH,
    gain: 1, split: 0.5,
    zoom: 1, x: 0, y: 0, // the picture's pixel in the middle of every canvas
  };
  let panels = [];

  const shot = () => report.pictures[state.picture];
  const labelOf = (source, picture = shot()) => (source === TRUTH ? "truth" : picture.techniques[source].label);

  // ---- data: unpacked when first looked at -------------------------------------------------------------------------

  const kept = new Map();
  const once = (key, make) => {
    if (!kept.has(key)) kept.set(key, make());
    return kept.get(key);
  };

  async function inflated(text) {
    const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  // The inverse of payload.py's pack_visibility.
  async function unpackedVisibility(text) {
    const bytes = await inflated(text);
    const count = bytes.length / 2;
    const values = new Uint16Array(count);
    let value = 0;
    for (let i = 0; i < count; i++) {
      const stored = (bytes[i] << 8) | bytes[count + i];
      value += stored & 1 ? -((stored + 1) >> 1) : stored >> 1;
      values[i] = value; // modulo 65536
    }
    return values;
  }

  // 16-bit visibility of a source; the mask's bits.
  const visibility = (picture, source, light) => once(`v${picture} ${source} ${light}`, () => {
    const data = report.pictures[picture];
    return unpackedVisibility(source === TRUTH ? data.lights[light].truth : data.techniques[source].visibility[light]);
  });
  const mask = (picture, light) => once(`m${picture} ${light}`, () => inflated(report.pictures[picture].lights[light].mask));

  const photograph = (picture, source) => once(`p${picture} ${source}`, async () => {
    const data = report.pictures[picture];
    const image = new Image();
    image.src = source === TRUTH ? data.picture : data.techniques[source].picture;
    await image.decode();
    return image;
  });

  // ---- painting: a layer of a source as an image of the picture's own pixels ---------------------------------------

  function newImage(picture, paint) {
    const { width, height } = report.pictures[picture];
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [width, height];
    const context = canvas.getContext("2d");
    const image = context.createImageData(width, height);
    const words = new Uint32Array(image.data.buffer);
    paint(words);
    context.putImageData(image, 0, 0);
    return canvas;
  }
  const word = (red, green, blue) => (0xff000000 | (blue << 16) | (green << 8) | red) >>> 0; // little-endian RGBA

  const visibilityImage = (picture, source, light) => once(`vi${picture} ${source} ${light}`, async () => {
    const values = await visibility(picture, source, light);
    return newImage(picture, (words) => {
      for (let i = 0; i < words.length; i++) {
        const grey = Math.round((255 * values[i]) / report.full);
        words[i] = word(grey, grey, grey);
      }
    });
  });

  // White is no error; a colour is full at an error of 1/gain, as in metrics.signed_error_image.
  async function errorImage(picture, source, light, gain) {
    const [values, truth, bits] = await Promise.all([
      visibility(picture, source, light), visibility(picture, TRUTH, light), mask(picture, light),
    ]);
    const ramp = (colour) => Uint32Array.from({ length: 256 }, (_, strength) =>
      word(...colour.map((full) => Math.round(255 - (strength / 255) * (255 - full)))));
    const [tooLight, tooDark] = [ramp(report.colours.tooLight), ramp(report.colours.tooDark)];
    const outside = word(...report.colours.outside);
    return newImage(picture, (words) => {
      for (let i = 0; i < words.length; i++) {
        const counts = bits[i >> 3] & (128 >> (i & 7));
        const error = values[i] - truth[i];
        const strength = Math.min(255, Math.round((255 * gain * Math.abs(error)) / report.full));
        words[i] = !counts ? outside : (error > 0 ? tooLight : tooDark)[strength];
      }
    });
  }

  function layerImage(picture, source, light, layer) {
    if (layer === "picture") return photograph(picture, source);
    if (layer === "visibility") return visibilityImage(picture, source, light);
    return errorImage(picture, source, light, state.gain);
  }

  // ---- the stage: panels that share one view of the picture --------------------------------------------------------

  function wanted() {
    if (state.mode === "slider") return [{ sources: [state.left, state.right], layer: state.layer }];
    const layersOf = (source) => (source === TRUTH ? ["picture", "visibility"] : ["picture", "visibility", "error"]);
    return [state.left, state.right].flatMap((source) => layersOf(source).map((layer) => ({ sources: [source], layer })));
  }

  function layOut() {
    at("stage").className = state.mode === "slider" ? "slider" : "";
    at("stage").replaceChildren();
    panels = wanted().map(({ sources, layer }) => {
      const figure = document.createElement("figure");
      const canvas = document.createElement("canvas");
      const caption = document.createElement("figcaption");
      const { width, height } = shot();
      canvas.style.aspectRatio = `${width} / ${height}`;
      if (sources.length > 1) canvas.style.maxWidth = `calc(80vh * ${width / height})`; // all of it fits the window
      caption.textContent = sources.length > 1
        ? `${layer}: ${labelOf(sources[0])} on the left, ${labelOf(sources[1])} on the right`
        : `${labelOf(sources[0])}: ${layer}`;
      canvas.setAttribute("role", "img");
      canvas.setAttribute("aria-label", `${caption.textContent}; ${shot().name}, ${shot().lights[state.light].name}`);
      figure.append(canvas, caption);
      at("stage").append(figure);
      steer(canvas);
      return { canvas, sources, layer, images: [] };
    });
    return paint();
  }

  // Counted, so that a slow painting never replaces a newer one.
  let paintings = 0;
  async function paint() {
    const painting = ++paintings;
    at("stage").ariaBusy = true;
    const images = await Promise.all(panels.map(({ sources, layer }) =>
      Promise.all(sources.map((source) => layerImage(state.picture, source, state.light, layer)))));
    if (painting !== paintings) return;
    panels.forEach((panel, index) => { panel.images = images[index]; });
    draw();
    at("stage").ariaBusy = false;
  }

  const scaleOf = (canvas) => (state.zoom * canvas.clientWidth) / shot().width; // CSS pixels per picture pixel

  function keepInView() {
    const { width, height } = shot();
    state.zoom = Math.min(Math.max(state.zoom, 1), MOST_ZOOM);
    const [halfWidth, halfHeight] = [width / 2 / state.zoom, height / 2 / state.zoom];
    state.x = Math.min(Math.max(state.x, halfWidth), width - halfWidth);
    state.y = Math.min(Math.max(state.y, halfHeight), height - halfHeight);
  }

  function draw() {
    keepInView();
    for (const { canvas, images } of panels) {
      if (!images.length) continue;
      const density = window.devicePixelRatio || 1;
      canvas.width = Math.round(canvas.clientWidth * density);
      canvas.height = Math.round(canvas.clientHeight * density);
      const context = canvas.getContext("2d");
      const scale = scaleOf(canvas) * density;
      const [left, top] = [canvas.width / 2 - state.x * scale, canvas.height / 2 - state.y * scale];
      context.imageSmoothingEnabled = scale < 1;
      context.imageSmoothingQuality = "high";
      const divider = images.length > 1 ? Math.round(state.split * canvas.width) : canvas.width;
      images.forEach((image, index) => {
        context.save();
        context.beginPath();
        context.rect(index ? divider : 0, 0, index ? canvas.width - divider : divider, canvas.height);
        context.clip();
        context.drawImage(image, left, top, shot().width * scale, shot().height * scale);
        context.restore();
      });
      outline(context, scale, left, top);
      if (images.length > 1) {
        context.fillStyle = "#fff";
        context.fillRect(divider - density, 0, 2 * density, canvas.height);
        context.strokeStyle = "#000";
        context.strokeRect(divider - density, -1, 2 * density, canvas.height + 2);
      }
    }
  }

  const worstOf = (source) => (source === TRUTH ? null : shot().techniques[source].worst[state.light]);
  const worstInView = () => worstOf(state.left) || worstOf(state.right);

  function outline(context, scale, left, top) {
    const worst = worstInView();
    if (!worst) return;
    const [x, y, width, height] = worst;
    for (const [colour, offset] of [["#000", 0], ["#fff", 5]]) {
      context.strokeStyle = colour;
      context.setLineDash([5, 5]);
      context.lineDashOffset = offset;
      context.strokeRect(left + x * scale, top + y * scale, width * scale, height * scale);
    }
    context.setLineDash([]);
  }

  function showWorst(worst) {
    if (!worst) return;
    const [x, y, width, height] = worst;
    [state.x, state.y] = [x + width / 2, y + height / 2];
    state.zoom = Math.min(shot().width / width, shot().height / height) / 2;
    draw();
  }

  function zoomBy(factor, x = state.x, y = state.y) {
    const before = state.zoom;
    state.zoom = Math.min(Math.max(before * factor, 1), MOST_ZOOM);
    const moved = 1 - before / state.zoom; // (x, y) stays where it is on the screen
    state.x += (x - state.x) * moved;
    state.y += (y - state.y) * moved;
    draw();
  }

  // ---- pointer and keys --------------------------------------------------------------------------------------------

  function pixelUnder(canvas, event) {
    const scale = scaleOf(canvas);
    return [
      state.x + (event.offsetX - canvas.clientWidth / 2) / scale,
      state.y + (event.offsetY - canvas.clientHeight / 2) / scale,
    ];
  }

  function steer(canvas) {
    let dragging = null;
    const nearDivider = (event) =>
      state.mode === "slider" && Math.abs(event.offsetX - state.split * canvas.clientWidth) < DIVIDER_REACH;
    canvas.addEventListener("pointerdown", (event) => {
      dragging = nearDivider(event) ? "divider" : "picture";
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      canvas.classList.toggle("dividing", dragging === "divider" || nearDivider(event));
      if (dragging === "divider") {
        setSplit(event.offsetX / canvas.clientWidth);
      } else if (dragging === "picture") {
        state.x -= event.movementX / scaleOf(canvas);
        state.y -= event.movementY / scaleOf(canvas);
        draw();
      }
      readOut(...pixelUnder(canvas, event));
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => { dragging = null; });
    canvas.addEventListener("dblclick", (event) => zoomBy(2, ...pixelUnder(canvas, event)));
    canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && !event.metaKey) return; // the page scrolls
      event.preventDefault();
      zoomBy(2 ** (-event.deltaY / 200), ...pixelUnder(canvas, event));
    }, { passive: false });
  }

  async function readOut(x, y) {
    const { width, height, lights } = shot();
    [x, y] = [Math.floor(x), Math.floor(y)];
    if (x < 0 || y < 0 || x >= width || y >= height) return;
    const [picture, light, i] = [state.picture, state.light, y * width + x];
    const share = (values) => values[i] / report.full;
    const truth = share(await visibility(picture, TRUTH, light));
    const bits = await mask(picture, light);
    const parts = [];
    for (const source of [state.left, state.right]) {
      if (source === TRUTH) continue;
      const seen = share(await visibility(picture, source, light));
      const error = seen - truth;
      parts.push(`${labelOf(source, report.pictures[picture])} ${seen.toFixed(4)} (${error < 0 ? "−" : "+"}${Math.abs(error).toFixed(4)})`);
    }
    const counts = bits[i >> 3] & (128 >> (i & 7));
    at("readout").textContent = `column ${x}, row ${y}, ${lights[light].name}: ${counts ? "" : "counts in no figure; "}`
      + `truth ${truth.toFixed(4)}; ${parts.join("; ")}`;
  }

  at("stage").addEventListener("keydown", (event) => {
    const view = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (view) {
      state.x += (view[0] * KEY_STEP * shot().width) / state.zoom;
      state.y += (view[1] * KEY_STEP * shot().height) / state.zoom;
      draw();
    } else if (event.key === "+" || event.key === "=") zoomBy(1.5);
    else if (event.key === "-") zoomBy(1 / 1.5);
    else if (event.key === "0") zoomBy(0);
    else return;
    event.preventDefault();
  });

  // ---- controls ----------------------------------------------------------------------------------------------------

  function setSplit(share) {
    state.split = Math.min(Math.max(share, 0), 1);
    at("split").value = Math.round(1000 * state.split);
    draw();
  }

  function fill(select, entries, value) {
    select.replaceChildren(...entries.map(([text, option]) => new Option(text, option, false, String(option) === String(value))));
    select.closest("label").hidden = entries.length < 2;
  }

  function fillChoices() {
    const { lights, techniques } = shot();
    fill(at("picture"), report.pictures.map((picture, index) => [picture.name, index]), state.picture);
    fill(at("light"), lights.map((light, index) => [light.name, index]), state.light);
    const sources = [...techniques.map((technique, index) => [technique.label, index]), ["truth", TRUTH]];
    fill(at("left"), sources, state.left);
    fill(at("right"), sources, state.right);
    showMode();
  }

  function showMode() {
    const slider = state.mode === "slider";
    at("left-name").textContent = slider ? "Left" : "Upper row";
    at("right-name").textContent = slider ? "Right" : "Lower row";
    at("layer").closest("label").hidden = !slider;
    at("split-label").hidden = !slider;
    document.querySelector(`[name=mode][value=${state.mode}]`).checked = true;
    at("layer").value = state.layer;
  }

  function showGain() {
    state.gain = 10 ** (at("gain").value / STEPS_OF_TEN);
    at("gain-text").textContent = state.gain.toPrecision(state.gain < 100 ? 2 : 3);
    at("gain").setAttribute("aria-valuetext", `times ${at("gain-text").textContent}, full colour at an error of ${(1 / state.gain).toPrecision(2)}`);
  }

  function choosePicture(index) {
    const names = [state.left, state.right].map((source) => labelOf(source));
    state.picture = index;
    const { width, height, lights, techniques } = shot();
    const sourceOf = (name) => {
      const found = techniques.findIndex((technique) => technique.label === name);
      return found < 0 ? TRUTH : found;
    };
    [state.left, state.right] = names.map(sourceOf);
    state.light = Math.min(state.light, lights.length - 1);
    [state.zoom, state.x, state.y] = [1, width / 2, height / 2];
    fillChoices();
  }

  const source = (text) => (text === TRUTH ? TRUTH : Number(text));
  at("picture").addEventListener("change", (event) => { choosePicture(Number(event.target.value)); layOut(); });
  at("light").addEventListener("change", (event) => { state.light = Number(event.target.value); layOut(); });
  at("left").addEventListener("change", (event) => { state.left = source(event.target.value); layOut(); });
  at("right").addEventListener("change", (event) => { state.right = source(event.target.value); layOut(); });
  at("layer").addEventListener("change", (event) => { state.layer = event.target.value; layOut(); });
  for (const choice of document.querySelectorAll("[name=mode]")) {
    choice.addEventListener("change", (event) => { state.mode = event.target.value; showMode(); layOut(); });
  }
  at("gain").addEventListener("input", () => { showGain(); paint(); paintCrops(); });
  at("split").addEventListener("input", (event) => setSplit(event.target.value / 1000));
  at("whole").addEventListener("click", () => zoomBy(0));
  at("closer").addEventListener("click", () => zoomBy(1.5));
  at("farther").addEventListener("click", () => zoomBy(1 / 1.5));
  at("worst").addEventListener("click", () => showWorst(worstInView()));
  at("controls").addEventListener("submit", (event) => event.preventDefault());
  window.addEventListener("resize", draw);

  // ---- worst regions beside the techniques -------------------------------------------------------------------------

  const cropsInView = new Set();
  const watcher = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      if (isIntersecting) { cropsInView.add(target); paintCrop(target); } else cropsInView.delete(target);
    }
  });
  const paintCrops = () => cropsInView.forEach(paintCrop);

  async function paintCrop(element) {
    const [picture, technique, light] = ["picture", "technique", "light"].map((name) => Number(element.dataset[name]));
    const [x, y, width, height] = report.pictures[picture].techniques[technique].worst[light];
    for (const canvas of element.querySelectorAll("canvas")) {
      const { layer } = canvas.dataset;
      const image = await layerImage(picture, layer === TRUTH ? TRUTH : technique, light, layer === TRUTH ? "visibility" : layer);
      [canvas.width, canvas.height] = [width, height];
      canvas.getContext("2d").drawImage(image, -x, -y);
    }
  }

  for (const element of document.querySelectorAll(".worst")) {
    watcher.observe(element);
    element.querySelector("button").addEventListener("click", () => {
      choosePicture(Number(element.dataset.picture));
      [state.left, state.right] = [Number(element.dataset.technique), TRUTH];
      state.light = Number(element.dataset.light);
      fillChoices();
      at("stage").scrollIntoView({ block: "center" });
      layOut().then(() => showWorst(worstOf(state.left)));
    });
  }

  for (const [id, colour] of [["too-light", "tooLight"], ["too-dark", "tooDark"], ["outside", "outside"]]) {
    at(id).style.background = `rgb(${report.colours[colour].join()})`;
  }
  at("no-error").style.background = "#fff";
  state.left = shot().best ?? TRUTH;
  choosePicture(0);
  showGain();
  layOut();
})();
