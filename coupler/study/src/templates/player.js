"use strict";
// The player of a report: a plane of the flow with its grains, or the grains in space, over time.
(() => {
  const data = JSON.parse(document.getElementById("player-data").textContent);
  const part = (name) => document.querySelector(`#player [data-part="${name}"]`);
  const canvas = part("view"), pen = canvas.getContext("2d");
  const curve = part("curve"), line = curve.getContext("2d");
  const [x0, y0, x1, y1] = data.view, [right, up, normal] = data.axes, names = ["x", "y", "z"];
  const space = data.cut !== null, count = data.times.length;
  let now = count - 1, playing = false, turn = 0.6, tilt = 0.35;

  const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const known = new Map();
  // Grains of an instant: position, radius, speed from 0 to 1, held, a copy that only the plane shows.
  function grains(instant) {
    if (!known.has(instant)) {
      if (known.size > 120) known.delete(known.keys().next().value);
      const raw = bytes(data.grains[instant]), view = new DataView(raw.buffer), list = [];
      for (let at = 0; at < raw.length; at += 10) {
        const value = (k) => data.steps[k][0] + data.steps[k][1] * view.getUint16(at + 2 * k, true);
        list.push({ at: [value(0), value(1), value(2)], r: value(3), speed: raw[at + 8] / 255, held: (raw[at + 9] & 1) > 0, copy: raw[at + 9] > 1 });
      }
      known.set(instant, list);
    }
    return known.get(instant);
  }

  function colour(stops, part) {
    const along = Math.min(Math.max(part, 0), 1) * (stops.length - 1), first = Math.min(Math.floor(along), stops.length - 2);
    const mixed = stops[first].map((from, c) => Math.round(from + (along - first) * (stops[first + 1][c] - from)));
    return `rgb(${mixed.join(",")})`;
  }

  const images = new Map();
  function image(quantity, instant) {
    const key = `${quantity} ${instant}`;
    if (!images.has(key)) {
      if (images.size > 120) images.delete(images.keys().next().value);
      const picture = new Image();
      picture.onload = draw;
      picture.src = `data:image/png;base64,${data.quantities[quantity].pictures[instant]}`;
      images.set(key, picture);
    }
    const picture = images.get(key);
    return picture.complete && picture.naturalWidth > 0 ? picture : null;
  }

  // The quantity that is coloured: a number, or the speed of the grains.
  const quantity = () => (part("quantity").value === "" ? null : Number(part("quantity").value));
  const shade = (grain) =>
    grain.held ? "#787878" : quantity() === null || inSpace() ? colour(data.colours, grain.speed) : "#cdcdcd";
  const inSpace = () => space && part("space").checked;

  function drawPlane() {
    const scale = canvas.width / (x1 - x0);
    const at = (x, y) => [(x - x0) * scale, (y1 - y) * scale];
    const picture = quantity() === null ? null : image(quantity(), now);
    if (picture) pen.drawImage(picture, 0, 0, canvas.width, canvas.height);
    pen.lineWidth = 1;
    pen.strokeStyle = "#141414";
    const outline = (fill) => {
      pen.fillStyle = fill;
      pen.fill();
      pen.stroke();
    };
    if (data.outlines.length) {
      for (const body of data.outlines[now]) {
        pen.beginPath();
        body.forEach(([x, y]) => pen.lineTo(...at(x, y)));
        pen.closePath();
        outline("#cdcdcd");
      }
      return;
    }
    for (const grain of grains(now)) {
      const aside = space ? grain.at[normal] - data.cut : 0;
      const seen = Math.sqrt(Math.max(grain.r * grain.r - aside * aside, 0));
      if (seen === 0) continue;
      pen.beginPath();
      pen.arc(...at(grain.at[right], grain.at[up]), seen * scale, 0, 2 * Math.PI);
      outline(shade(grain));
    }
  }

  function drawSpace() {
    const ends = data.ends, middle = ends.map(([low, high]) => (low + high) / 2);
    const reach = Math.hypot(...ends.map(([low, high]) => high - low));
    const scale = Math.min(canvas.width, canvas.height) / reach;
    const [c, s, ct, st] = [Math.cos(turn), Math.sin(turn), Math.cos(tilt), Math.sin(tilt)];
    // To the right, downwards, and away from the eye.
    const seen = (p) => {
      const [x, y, z] = p.map((value, k) => value - middle[k]);
      const [a, b] = [x * c - y * s, x * s + y * c];
      return [canvas.width / 2 + scale * a, canvas.height / 2 - scale * (z * ct + b * st), b * ct - z * st];
    };
    pen.strokeStyle = "#999";
    const corner = (k) => seen(ends.map(([low, high], a) => ((k >> a) & 1 ? high : low)));
    for (let k = 0; k < 8; k++)
      for (let a = 0; a < 3; a++)
        if (!((k >> a) & 1)) {
          pen.beginPath();
          pen.moveTo(...corner(k).slice(0, 2));
          pen.lineTo(...corner(k | (1 << a)).slice(0, 2));
          pen.stroke();
        }
    const balls = grains(now).filter((grain) => !grain.copy).map((grain) => ({ grain, place: seen(grain.at) }));
    balls.sort((a, b) => b.place[2] - a.place[2]);
    const ball = ({ grain, place: [x, y] }) => {
      const r = Math.max(grain.r * scale, 0.7), fill = shade(grain);
      pen.beginPath();
      pen.arc(x, y, r, 0, 2 * Math.PI);
      pen.fillStyle = fill;
      pen.fill();
      if (r < 2) return;
      pen.lineWidth = 0.5;
      pen.strokeStyle = "#141414";
      pen.stroke();
      pen.beginPath();
      pen.arc(x - 0.3 * r, y - 0.3 * r, 0.35 * r, 0, 2 * Math.PI);
      pen.fillStyle = "rgba(255,255,255,0.35)";
      pen.fill();
    };
    const picture = quantity() === null ? null : image(quantity(), now);
    if (!picture) return balls.forEach(ball);
    // What lies behind the plane, the plane, what lies before it.
    const point = (a, b) => {
      const p = [0, 0, 0];
      [p[right], p[up], p[normal]] = [a, b, data.cut];
      return seen(p);
    };
    const ahead = seen(middle.map((value, k) => (k === normal ? value + 1 : value)))[2] > seen(middle)[2] ? 1 : -1;
    const behind = ({ grain }) => (grain.at[normal] - data.cut) * ahead > 0;
    balls.filter(behind).forEach(ball);
    const [o, r, d] = [point(x0, y1), point(x1, y1), point(x0, y0)];
    const [w, h] = [picture.naturalWidth, picture.naturalHeight];
    pen.setTransform((r[0] - o[0]) / w, (r[1] - o[1]) / w, (d[0] - o[0]) / h, (d[1] - o[1]) / h, o[0], o[1]);
    pen.globalAlpha = 0.85;
    pen.drawImage(picture, 0, 0);
    pen.globalAlpha = 1;
    pen.setTransform(1, 0, 0, 1, 0, 0);
    balls.filter((one) => !behind(one)).forEach(ball);
  }

  const short = (value) => (value === 0 ? "0" : String(Number(value.toPrecision(4))));

  function drawScale() {
    const q = quantity(), of = q === null ? null : data.quantities[q];
    const [low, high, unit] = of ? [of.low, of.high, of.unit] : [0, data.fastest, "m/s"];
    const stops = (of ? of.colours : data.colours).map((_, k, all) => colour(all, k / (all.length - 1)));
    part("scale").style.background = `linear-gradient(to right, ${stops.join(",")})`;
    part("low").textContent = short(low);
    part("high").textContent = `${short(high)} ${unit}`;
  }

  // First and last time of the curve.
  function span() {
    const times = data.series.times;
    return [Math.min(times[0], data.times[0]), Math.max(times[times.length - 1], data.times[count - 1])];
  }

  function drawCurve() {
    const ratio = window.devicePixelRatio || 1, [w, h] = [curve.clientWidth * ratio, 160 * ratio];
    [curve.width, curve.height] = [w, h];
    const values = data.series.values[Number(part("column").value)], times = data.series.times;
    if (!values || times.length < 2) return;
    const [t0, t1] = span();
    const [low, high] = [Math.min(...values), Math.max(...values)];
    const [left, foot, head] = [8 * ratio, 20 * ratio, 20 * ratio];
    const x = (t) => left + ((w - 2 * left) * (t - t0)) / (t1 - t0);
    const y = (value) => h - foot - ((h - foot - head) * (value - low)) / (high - low || 1);
    line.font = `${12 * ratio}px system-ui, sans-serif`;
    line.fillStyle = "#444";
    line.fillText(short(high), left, head - 6 * ratio);
    line.fillText(`${short(low)}   (t from ${short(t0)} to ${short(t1)} s)`, left, h - 5 * ratio);
    line.strokeStyle = "#2c728e";
    line.lineWidth = 1.6 * ratio;
    line.beginPath();
    values.forEach((value, k) => line.lineTo(x(times[k]), y(value)));
    line.stroke();
    line.strokeStyle = "#d6604d";
    line.beginPath();
    line.moveTo(x(data.times[now]), head);
    line.lineTo(x(data.times[now]), h - foot);
    line.stroke();
  }

  function draw() {
    const ratio = window.devicePixelRatio || 1, aspect = inSpace() ? 0.75 : (y1 - y0) / (x1 - x0);
    // Never taller than the window.
    const most = Math.min(0.75 * window.innerHeight, 700);
    const width = Math.min(canvas.parentElement.clientWidth, most / aspect);
    canvas.style.width = `${width}px`;
    canvas.style.touchAction = inSpace() ? "none" : "auto";
    [canvas.width, canvas.height] = [Math.round(width * ratio), Math.max(Math.round(width * aspect * ratio), 1)];
    pen.imageSmoothingEnabled = false;
    pen.clearRect(0, 0, canvas.width, canvas.height);
    (inSpace() ? drawSpace : drawPlane)();
    part("time").textContent = `t = ${short(data.times[now])} s`;
    part("instant").value = now;
    drawScale();
    drawCurve();
  }

  function show(instant) {
    now = (instant + count) % count;
    draw();
  }

  const option = (list, value, text) => {
    const entry = document.createElement("option");
    [entry.value, entry.textContent] = [value, text];
    list.append(entry);
  };
  data.quantities.forEach((q, k) => option(part("quantity"), k, `${q.name} of the fluid`));
  // Where all are held, their speed shows nothing.
  if (data.grains.some((text) => text !== "") && (data.fastest > 1e-300 || !data.quantities.length)) option(part("quantity"), "", "speed of the grains");
  data.series.names.forEach((name, k) => option(part("column"), k, name));
  part("curve").hidden = part("column").hidden = data.series.names.length === 0;
  part("in-space").hidden = !space;
  part("instant").max = count - 1;
  part("plane").textContent = space ? `Plane ${names[normal]} = ${short(data.cut)} m. ` : "";

  part("instant").addEventListener("input", (event) => show(Number(event.target.value)));
  for (const name of ["quantity", "column", "space"]) part(name).addEventListener("change", draw);
  window.addEventListener("resize", draw);
  part("play").addEventListener("click", () => {
    playing = !playing;
    part("play").textContent = playing ? "❚❚" : "▶";
    if (playing) step();
  });
  // The whole run in some eight seconds, twenty instants a second at most.
  const pause = Math.max(50, Math.min(400, 8000 / count));
  function step() {
    if (!playing) return;
    show(now + 1);
    setTimeout(step, pause);
  }
  let held = null;
  canvas.addEventListener("pointerdown", (event) => (held = [event.clientX, event.clientY]));
  window.addEventListener("pointerup", () => (held = null));
  window.addEventListener("pointermove", (event) => {
    if (!held || !inSpace()) return;
    turn -= (event.clientX - held[0]) / 150;
    tilt = Math.min(Math.max(tilt + (event.clientY - held[1]) / 150, -1.5), 1.5);
    held = [event.clientX, event.clientY];
    draw();
  });
  curve.addEventListener("click", (event) => {
    const [t0, t1] = span();
    const t = t0 + ((t1 - t0) * (event.offsetX - 8)) / (curve.clientWidth - 16);
    let nearest = 0;
    data.times.forEach((time, k) => (Math.abs(time - t) < Math.abs(data.times[nearest] - t) ? (nearest = k) : null));
    show(nearest);
  });
  draw();
})();
