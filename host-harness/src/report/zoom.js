for (const svg of document.querySelectorAll("svg")) {
  const whole = svg.getAttribute("viewBox").split(" ").map(Number);
  let from = null;
  const at = (event) => {
    const box = svg.getBoundingClientRect();
    const view = svg.getAttribute("viewBox").split(" ").map(Number);
    return view[0] + ((event.clientX - box.left) / box.width) * view[2];
  };
  svg.setAttribute("preserveAspectRatio", "none");
  svg.style.aspectRatio = whole[2] + " / " + whole[3];
  svg.addEventListener("pointerdown", (event) => { from = at(event); });
  svg.addEventListener("pointerup", (event) => {
    if (from === null) return;
    const to = at(event);
    const low = Math.min(from, to), width = Math.abs(to - from);
    from = null;
    if (width > 8) svg.setAttribute("viewBox", [low, whole[1], width, whole[3]].join(" "));
  });
  svg.addEventListener("dblclick", () => svg.setAttribute("viewBox", whole.join(" ")));
}
