// Turns the scene: every shape carries its points of the room in data-p, "x,y,z x,y,z;x,y,z ...".
document.documentElement.classList.add("script");
for (const svg of document.querySelectorAll("svg.scene")) {
  const view = svg.dataset, [middleX, middleY] = [view.width / 2, view.height / 2];
  const center = view.center.split(",").map(Number), start = [Number(view.yaw), Number(view.pitch)];
  let [yaw, pitch] = start, zoom = Number(view.zoom), held = null;
  const shapes = [...svg.querySelectorAll("[data-p]")].map(node =>
    [node, node.dataset.p.split(";").map(line => line.split(" ").map(point => point.split(",").map(Number)))]);
  const place = point => {
    const [x, y, z] = point.map((value, axis) => value - center[axis]);
    const across = Math.cos(yaw) * x + Math.sin(yaw) * y, away = Math.cos(yaw) * y - Math.sin(yaw) * x;
    const up = Math.cos(pitch) * z + Math.sin(pitch) * away;
    return [(middleX + zoom * across).toFixed(1), (middleY - zoom * up).toFixed(1)];
  };
  const draw = () => {
    for (const [node, lines] of shapes) {
      if (node.tagName === "text") {
        [node.attributes.x.value, node.attributes.y.value] = place(lines[0][0]);
      } else {
        node.setAttribute("d", lines.map(line => "M" + line.map(place).join("L") + (line[1] ? "" : "h0")).join(""));
      }
    }
  };
  svg.addEventListener("pointerdown", event => { held = [event.clientX, event.clientY]; svg.setPointerCapture(event.pointerId); });
  svg.addEventListener("pointerup", () => { held = null; });
  svg.addEventListener("pointermove", event => {
    if (!held) return;
    yaw -= (event.clientX - held[0]) * 0.008;
    pitch = Math.min(Math.max(pitch + (event.clientY - held[1]) * 0.008, 0), Math.PI / 2);
    held = [event.clientX, event.clientY];
    draw();
  });
  svg.addEventListener("wheel", event => { event.preventDefault(); zoom *= Math.exp(-event.deltaY * 0.001); draw(); }, { passive: false });
  for (const button of svg.parentNode.querySelectorAll("button")) {
    button.addEventListener("click", () => {
      [yaw, pitch] = button.dataset.yaw ? [Number(button.dataset.yaw), Number(button.dataset.pitch)] : start;
      zoom = Number(view.zoom);
      draw();
    });
  }
}
