"use strict";
// Plays the motion in a picture: outlines of even times, one at a time, in place of the flashes. A page's script, or
// that of the operator's page, calls it with the picture and where its controls go.
function player(picture, controls) {
  const moving = picture.querySelector(".played");
  if (moving === null) return;
  const flashes = picture.querySelector(".flashes");
  const paths = [...moving.querySelectorAll("[data-d]")].map((path) => [path, path.dataset.d.split("|")]);
  const step = Number(moving.dataset.step);
  const from = Number(moving.dataset.from);
  const last = Number(moving.dataset.count) - 1;
  const button = document.createElement("button");
  const slider = document.createElement("input");
  const clock = document.createElement("output");
  const slow = document.createElement("select");
  button.type = "button";
  Object.assign(slider, { type: "range", min: 0, max: last, step: "any", value: 0 });
  slider.setAttribute("aria-label", "time of the motion");
  slow.setAttribute("aria-label", "speed");
  for (const [speed, words] of [[1, "1×"], [0.25, "¼×"], [0.1, "⅒×"]]) slow.add(new Option(words, speed));
  controls.replaceChildren(button, slider, clock, slow);
  controls.hidden = false;
  let plays = false;
  let before = null;
  // Null: the flashes, all at once.
  function show(at) {
    moving.setAttribute("display", at === null ? "none" : "inline");
    flashes.setAttribute("display", at === null ? "inline" : "none");
    if (at === null) return;
    const frame = Math.min(last, Math.max(0, Math.round(at)));
    for (const [path, frames] of paths) path.setAttribute("d", frames[frame]);
    clock.textContent = `${(from + at * step).toFixed(2)} s`;
  }
  function set(isPlaying) {
    plays = isPlaying;
    before = null;
    button.textContent = plays ? "Pause" : "Play";
    if (plays) requestAnimationFrame(tick);
  }
  // How long it has stood at its end, in frames.
  let waited = 0;
  function tick(now) {
    if (!plays) return;
    const frames = before === null ? 0 : (Number(slow.value) * (now - before)) / 1000 / step;
    before = now;
    const at = Number(slider.value) + frames;
    waited = at > last ? waited + frames : 0;
    const isOver = waited * step > 0.6 * Number(slow.value);
    slider.value = isOver ? 0 : Math.min(at, last);
    show(Number(slider.value));
    requestAnimationFrame(tick);
  }
  button.addEventListener("click", () => {
    if (!plays) show(Number(slider.value));
    set(!plays);
  });
  slider.addEventListener("input", () => {
    set(false);
    show(Number(slider.value));
  });
  set(false);
  clock.textContent = `${from.toFixed(2)} s`;
}
addEventListener("DOMContentLoaded", () => {
  for (const figure of document.querySelectorAll("figure.plays")) {
    player(figure.querySelector("svg"), figure.querySelector(".controls"));
  }
});
