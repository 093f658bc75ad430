'use strict';
for (const plot of document.querySelectorAll('svg.zoom')) {
  const field = plot.querySelector('.field'), ticks = plot.querySelector('.ticks');
  const hover = plot.querySelector('.hover'), names = plot.querySelector('.names');
  const data = plot.dataset, log = {x: +data.xlog, y: +data.ylog};
  const full = {x: [+data.x0, +data.x1], y: [+data.y0, +data.y1]};
  const left = +field.getAttribute('x'), top = +field.getAttribute('y');
  const width = +field.getAttribute('width'), height = +field.getAttribute('height');
  const make = (name, attributes, parent) => {
    const node = document.createElementNS('http://www.w3.org/2000/svg', name);
    for (const key in attributes) node.setAttribute(key, attributes[key]);
    return parent.appendChild(node);
  };
  // In the field's own pixels, as drawn.
  const lines = [...field.querySelectorAll('.line')].map(path => {
    const stem = path.classList.contains('stem');
    let points = path.getAttribute('d').split(/[ML]/).slice(1).map(p => p.split(' ').map(Number));
    if (stem) points = points.filter((_, k) => k % 2);
    return {name: path.dataset.name, points};
  }).filter(line => line.name);
  let seen = [0, width, 0, height], from = null;
  const value = {
    x: p => full.x[0] + p / width * (full.x[1] - full.x[0]),
    y: p => full.y[1] - p / height * (full.y[1] - full.y[0]),
  };
  // Of a logarithmic axis the numbers are powers of ten.
  const shown = (axis, v, digits) => (log[axis] ? 10 ** v : v).toPrecision(digits);
  const decades = (low, high) => {
    const all = [], within = high - low > 3.5 ? [1] : [1, 2, 5];
    for (let power = Math.floor(low); power <= high; power++) {
      for (const factor of within) {
        const at = power + Math.log10(factor), label = String(+(factor * 10 ** power).toPrecision(1));
        if (at >= low && at <= high) all.push([at, label]);
      }
    }
    if (all.length > 1) return all;
    return round(10 ** low, 10 ** high, 3).map(([v, label]) => [Math.log10(v), label]);
  };
  const round = (low, high, about) => {
    const raw = (high - low) / about, power = 10 ** Math.floor(Math.log10(raw));
    const step = power * [1, 2, 5, 10].find(f => f * power >= 0.999 * raw), all = [];
    for (let k = Math.ceil(low / step); k * step <= high && all.length < 40; k++) all.push(k * step);
    const most = Math.max(Math.abs(low), Math.abs(high));
    const places = Math.min(20, Math.max(0, -Math.floor(Math.log10(step))));
    return all.map(v => [v, v === 0 ? '0' : most < 1e-3 || most >= 1e6
      ? v.toExponential(2) : v.toFixed(places)]);
  };
  const show = () => {
    const [x, w, y, h] = seen;
    field.setAttribute('viewBox', `${x} ${y} ${w} ${h}`);
    ticks.replaceChildren();
    const low = value.x(x), high = value.x(x + w), under = value.y(y + h), over = value.y(y);
    for (const [v, label] of log.x ? decades(low, high) : round(low, high, Math.max(3, width / 95))) {
      const at = left + (v - low) / (high - low) * width;
      make('path', {d: `M${at} ${top}V${top + height}`, class: 'grid'}, ticks);
      make('text', {x: at, y: top + height + 14, 'text-anchor': 'middle'}, ticks).textContent = label;
    }
    for (const [v, label] of log.y ? decades(under, over) : round(under, over, Math.max(3, height / 28))) {
      const at = top + (over - v) / (over - under) * height;
      make('path', {d: `M${left} ${at}H${left + width}`, class: 'grid'}, ticks);
      make('text', {x: left - 5, y: at + 3.5, 'text-anchor': 'end'}, ticks).textContent = label;
    }
  };
  const across = event => {
    const matrix = plot.getScreenCTM();
    const p = (event.clientX - matrix.e) / matrix.a - left;
    return seen[0] + Math.min(Math.max(p, 0), width) / width * seen[1];
  };
  const pointer = make('path', {class: 'pointer'}, field);
  const chosen = make('rect', {class: 'chosen', y: -9999, height: 19998, width: 0}, field);
  plot.addEventListener('mousedown', event => { from = across(event); event.preventDefault(); });
  plot.addEventListener('mousemove', event => {
    const x = across(event);
    if (from !== null) {
      chosen.setAttribute('x', Math.min(x, from));
      chosen.setAttribute('width', Math.abs(x - from));
    }
    pointer.setAttribute('d', `M${x} -9999V9999`);
    const near = lines.map(line => {
      let best = null;
      for (const p of line.points) if (!best || Math.abs(p[0] - x) < Math.abs(best[0] - x)) best = p;
      return best ? `${line.name} ${shown('y', value.y(best[1]), 4)}` : '';
    });
    if (names) names.setAttribute('visibility', 'hidden');
    hover.textContent = `at ${shown('x', value.x(x), 5)}: ${near.join(', ')}`;
  });
  plot.addEventListener('mouseleave', () => {
    hover.textContent = '';
    pointer.removeAttribute('d');
    if (names) names.removeAttribute('visibility');
  });
  window.addEventListener('mouseup', event => {
    if (from === null) return;
    const to = across(event), x = Math.min(from, to), w = Math.abs(to - from);
    from = null;
    chosen.setAttribute('width', 0);
    if (w < seen[1] / 200) return;
    const inside = lines.flatMap(l => l.points.filter(p => p[0] >= x && p[0] <= x + w).map(p => p[1]));
    const high = Math.min(...inside), low = Math.max(...inside), margin = 0.05 * (low - high) || 1;
    seen = inside.length > 1 ? [x, w, high - margin, low - high + 2 * margin] : [x, w, seen[2], seen[3]];
    show();
  });
  plot.addEventListener('dblclick', () => { seen = [0, width, 0, height]; show(); });
}
