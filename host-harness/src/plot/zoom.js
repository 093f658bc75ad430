'use strict';
// Fits every plot to the width there is, and zooms: drag or pinch across a plot, double-click or double-tap
// for all of it. Plots with the same link show the same range.
(() => {
  const all = [];
  const make = (name, attributes, parent) => {
    const node = document.createElementNS('http://www.w3.org/2000/svg', name);
    for (const key in attributes) node.setAttribute(key, attributes[key]);
    return parent.appendChild(node);
  };
  const round = (low, high, about) => {
    const raw = (high - low) / about, power = 10 ** Math.floor(Math.log10(raw)), values = [];
    const step = power * [1, 2, 5, 10].find(f => f * power >= 0.999 * raw);
    for (let k = Math.ceil(low / step); k * step <= high && values.length < 40; k++) values.push(k * step);
    // One number alone says nothing of the scale.
    if (values.length < 2 && about < 20) return round(low, high, 2 * about);
    const most = Math.max(Math.abs(low), Math.abs(high));
    const places = Math.min(20, Math.max(0, -Math.floor(Math.log10(step) + 1e-9)));
    return values.map(v => [v, Math.abs(v) < 1e-9 * step ? '0' : most < 1e-3 || most >= 1e6
      ? v.toExponential(2) : v.toFixed(places)]);
  };
  const raised = power => String(power).replace(/./g, c => '⁻⁰¹²³⁴⁵⁶⁷⁸⁹'['-0123456789'.indexOf(c)]);
  const powerOfTen = (factor, power) => (Math.abs(power) <= 3 ? String(+(factor * 10 ** power).toPrecision(1))
    : `${factor === 1 ? '' : `${factor}·`}10${raised(power)}`);
  const decades = (low, high, about) => {
    const values = [], within = high - low > 3.5 ? [1] : [1, 2, 5];
    const apart = Math.max(1, Math.ceil((high - low) / (2 * about)));
    for (let power = Math.floor(low); power <= high; power++) {
      if (power % apart) continue;
      for (const factor of within) {
        const at = power + Math.log10(factor);
        if (at >= low && at <= high) values.push([at, powerOfTen(factor, power)]);
      }
    }
    if (values.length > 1) return values;
    return round(10 ** low, 10 ** high, 3).map(([v, label]) => [Math.log10(v), label]);
  };

  for (const plot of document.querySelectorAll('.panel > svg.plot')) {
    const panel = plot.parentNode, data = plot.dataset, zooms = plot.classList.contains('zoom');
    const [field, ticks, frame] = ['.field', '.ticks', '.frame'].map(name => plot.querySelector(name));
    const hover = panel.querySelector('.hover'), reset = panel.querySelector('.reset');
    const log = {x: +data.xlog, y: +data.ylog}, unit = +data.unit;
    const full = {x: [+data.x0, +data.x1], y: [+data.y0, +data.y1]};
    const number = (node, name) => +node.getAttribute(name);
    const left = number(field, 'x'), top = number(field, 'y');
    const width = number(field, 'width'), height = number(field, 'height');
    const natural = number(plot, 'width'), outer = number(plot, 'height');
    let shown = width, seen = [0, width, 0, height];
    // As drawn, in pixels of the field as it was first.
    const lines = [...field.querySelectorAll('.line')].map(path => {
      const stem = path.classList.contains('stem');
      const runs = path.getAttribute('d').split('M').slice(1)
        .map(run => run.split('L').map(p => p.split(' ').map(Number)));
      return {name: path.dataset.name, runs: stem ? [runs.map(run => run[1])] : runs, stem};
    });
    const named = lines.filter(line => line.name);
    const value = {
      x: p => full.x[0] + p / width * (full.x[1] - full.x[0]),
      y: p => full.y[1] - p / height * (full.y[1] - full.y[0]),
    };
    const pixel = v => (v - full.x[0]) / (full.x[1] - full.x[0]) * width;
    const written = (axis, v, digits) => String(+(log[axis] ? 10 ** v : v).toPrecision(digits));
    const wanted = (axis, from, to, about) => (log[axis] ? decades : round)(from, to, about);

    // The name of a dot stands beside it where it is whole and covers no other, or nowhere: the dot's note says more.
    const label = () => {
      const [x, w, y, h] = seen, taken = [];
      for (const text of field.querySelectorAll('text')) {
        const [a, b] = [number(text, 'x'), number(text, 'y')], long = text.getComputedTextLength();
        const [right, up] = [(a - 6 - x) / w * shown, (b + 6 - y) / h * height];
        const places = [[6, -6], [-6 - long, -6], [6, 14], [-6 - long, 14]]
          .map(([aside, down]) => [right + aside, up + down])
          .filter(([from, foot]) => from >= 0 && from + long <= shown && foot >= 10 && foot <= height - 3)
          .filter(([from, foot]) => taken.every(([f, t, under]) => from > t + 2 || from + long < f - 2
            || Math.abs(foot - under) > 12));
        text.setAttribute('visibility', places.length ? 'visible' : 'hidden');
        if (!places.length) continue;
        const [from, foot] = places[0];
        taken.push([from, from + long, foot]);
        text.setAttribute('transform', `translate(${x + from * w / shown} ${y + foot * h / height}) `
          + `scale(${w / shown} ${h / height}) translate(${-a} ${-b})`);
      }
    };
    // Where a number below the field stands whole.
    const inside = (node, at) => Math.min(at, shown + natural - width - node.getComputedTextLength() / 2);

    const show = () => {
      const [x, w, y, h] = seen, bottom = top + height;
      field.setAttribute('viewBox', `${x} ${y} ${w} ${h}`);
      const whole = w >= width * 0.9999;
      if (reset) reset.hidden = whole;
      label();
      const marked = axis => data.marked.includes(axis);
      const kept = axis => [...ticks.children].filter(node => node.dataset.of === axis);
      for (const axis of ['x', 'y']) if (!marked(axis)) kept(axis).forEach(node => node.remove());
      if (!marked('x')) {
        const [from, to] = [value.x(x), value.x(x + w)];
        for (const [v, text] of wanted('x', from, to, Math.max(4, shown / 80))) {
          const at = left + (v - from) / (to - from) * shown;
          make('path', {d: `M${at} ${top}V${bottom}`, class: 'grid', 'data-of': 'x'}, ticks);
          const node = make('text', {y: bottom + 14, 'text-anchor': 'middle', 'data-of': 'x'}, ticks);
          node.textContent = text;
          node.setAttribute('x', inside(node, at));
        }
      } else {
        for (const node of kept('x')) {
          const at = left + (+node.dataset.at * width - x) / w * shown;
          if (node.tagName === 'path') node.setAttribute('d', `M${at} ${top}V${bottom}`);
          else node.setAttribute('x', inside(node, at));
        }
      }
      if (marked('y')) {
        for (const node of kept('y')) {
          if (node.tagName === 'path') {
            node.setAttribute('d', node.getAttribute('d').replace(/H.*/, `H${left + shown}`));
          }
        }
        return;
      }
      const [under, over] = [value.y(y + h), value.y(y)];
      for (const [v, text] of wanted('y', under, over, Math.min(8, Math.max(3, height / 28)))) {
        const at = top + (over - v) / (over - under) * height;
        make('path', {d: `M${left} ${at}H${left + shown}`, class: 'grid', 'data-of': 'y'}, ticks);
        make('text', {x: left - 5, y: at + 3.5, 'text-anchor': 'end', 'data-of': 'y'}, ticks)
          .textContent = text;
      }
    };

    // Fits the drawing to the page, never wider than it was made.
    const fit = () => {
      const room = Math.min(natural, panel.clientWidth);
      if (room < 120) return;
      shown = width - (natural - room);
      plot.setAttribute('width', room);
      plot.setAttribute('viewBox', `0 0 ${room} ${outer}`);
      for (const node of [field, frame]) node.setAttribute('width', shown);
      plot.querySelector('.across').setAttribute('x', left + shown / 2);
      show();
    };

    const zero = full.y[1] / (full.y[1] - full.y[0]) * height;
    // The height that shows all lines between two pixels across.
    const tall = (x, w) => {
      let high = Infinity, low = -Infinity;
      for (const {runs, stem} of lines) {
        for (const run of runs) {
          for (let k = 0; k < run.length; k++) {
            const beside = run[k + 1] || run[k - 1] || run[k];
            const near = stem ? run[k][0] >= x && run[k][0] <= x + w
              : Math.max(run[k][0], beside[0]) >= x && Math.min(run[k][0], beside[0]) <= x + w;
            const inside = run[k][0] >= x && run[k][0] <= x + w;
            if (!near) continue;
            // A corner outside counts where the line enters the window.
            let up = run[k][1];
            if (!inside && beside[0] !== run[k][0]) {
              const edge = run[k][0] < x ? x : x + w;
              up += (edge - run[k][0]) / (beside[0] - run[k][0]) * (beside[1] - run[k][1]);
            }
            high = Math.min(high, up);
            low = Math.max(low, up);
            if (stem) [high, low] = [Math.min(high, zero), Math.max(low, zero)];
          }
        }
      }
      if (!(low >= high)) return null;
      const margin = 0.05 * (low - high) || 1;
      return [high - margin, low - high + 2 * margin];
    };
    const look = (x, w) => {
      w = Math.min(Math.max(w, width / 5000), width);
      x = Math.min(Math.max(x, 0), width - w);
      const most = w >= width * 0.9999;
      seen = most ? [0, width, 0, height] : [x, w, ...(tall(x, w) || [seen[2], seen[3]])];
      show();
    };
    // In plain units, for the plots beside.
    const range = () => [value.x(seen[0]) / unit, value.x(seen[0] + seen[1]) / unit];
    const go = (x, w) => {
      look(x, w);
      const whole = seen[1] >= width * 0.9999;
      for (const other of all) {
        if (data.link && other.link === data.link && other.plot !== plot) {
          if (whole) other.whole(); else other.between(range());
        }
      }
    };
    all.push({
      plot, link: data.link, fit, range,
      whole: () => look(0, width),
      between: ([low, high]) => {
        const [from, to] = [pixel(low * unit), pixel(high * unit)];
        if (to > 0 && from < width) look(Math.max(from, 0), Math.min(to, width) - Math.max(from, 0));
      },
      zoom: (low, high) => go(pixel(low * unit), pixel(high * unit) - pixel(low * unit)),
    });
    if (!zooms) continue;

    const pointer = make('path', {class: 'pointer'}, field);
    const chosen = make('rect', {class: 'chosen', y: -9999, height: 19998, width: 0}, field);
    const across = clientX => {
      const box = plot.getBoundingClientRect(), scale = number(plot, 'width') / box.width;
      const p = (clientX - box.left) * scale - left;
      return seen[0] + Math.min(Math.max(p, 0), shown) / shown * seen[1];
    };
    const at = (runs, x) => {
      let best = null;
      for (const run of runs) {
        if (x < run[0][0] || x > run[run.length - 1][0]) continue;
        let k = run.findIndex(p => p[0] >= x);
        if (k <= 0) k = Math.min(1, run.length - 1);
        const [from, to] = [run[Math.max(k - 1, 0)], run[k]];
        best = to[0] === from[0] ? to[1]
          : from[1] + (x - from[0]) / (to[0] - from[0]) * (to[1] - from[1]);
      }
      return best;
    };
    const tell = x => {
      pointer.setAttribute('d', `M${x} -9999V9999`);
      const told = named.map(({name, runs, stem}) => {
        if (stem) {
          const near = runs[0].reduce((a, b) => (Math.abs(b[0] - x) < Math.abs(a[0] - x) ? b : a));
          return `${name} ${written('y', value.y(near[1]), 4)}`;
        }
        const y = at(runs, x);
        return y === null ? '' : `${name} ${written('y', value.y(y), 4)}`;
      }).filter(Boolean);
      hover.textContent = `at ${written('x', value.x(x), 5)}: ${told.join(', ')}`;
    };
    const quiet = () => { hover.textContent = ''; pointer.removeAttribute('d'); };

    // Fingers and the mouse: one finger moves a part along, two zoom it, the mouse chooses one.
    const down = new Map();
    let from = null, pinch = null, tapped = 0;
    plot.addEventListener('pointerdown', event => {
      down.set(event.pointerId, event.clientX);
      if (event.pointerType === 'mouse') {
        if (event.button !== 0) return;
        try { plot.setPointerCapture(event.pointerId); } catch { /* gone again */ }
        from = across(event.clientX);
        event.preventDefault();
        return;
      }
      const now = event.timeStamp;
      if (down.size === 1 && now - tapped < 350) go(0, width);
      tapped = now;
      const ends = [...down.values()];
      pinch = {ends, values: ends.map(across), seen: [...seen]};
    });
    plot.addEventListener('pointermove', event => {
      if (event.pointerType === 'mouse') {
        const x = across(event.clientX);
        if (from !== null) {
          chosen.setAttribute('x', Math.min(x, from));
          chosen.setAttribute('width', Math.abs(x - from));
        }
        tell(x);
        return;
      }
      if (!down.has(event.pointerId)) return;
      down.set(event.pointerId, event.clientX);
      const box = plot.getBoundingClientRect(), scale = number(plot, 'width') / box.width;
      const share = clientX => ((clientX - box.left) * scale - left) / shown;
      const [one, two] = [...down.values()];
      if (two !== undefined && pinch && pinch.values.length > 1) {
        const [a, b] = [share(one), share(two)], [u, v] = pinch.values;
        if (Math.abs(b - a) > 0.02 && (v - u) / (b - a) > 0) {
          const w = (v - u) / (b - a);
          go(u - a * w, w);
        }
      } else if (pinch && seen[1] < width * 0.9999) {
        go(pinch.seen[0] - (share(one) - share(pinch.ends[0])) * pinch.seen[1], pinch.seen[1]);
      } else {
        tell(across(event.clientX));
      }
    });
    const lift = event => {
      down.delete(event.pointerId);
      const ends = [...down.values()];
      pinch = ends.length ? {ends, values: ends.map(across), seen: [...seen]} : null;
      if (from === null) return;
      const to = across(event.clientX), x = Math.min(from, to), w = Math.abs(to - from);
      from = null;
      chosen.setAttribute('width', 0);
      if (w > seen[1] / 200) go(x, w);
    };
    plot.addEventListener('pointerup', lift);
    plot.addEventListener('pointercancel', event => { from = null; lift(event); });
    plot.addEventListener('pointerleave', quiet);
    plot.addEventListener('dblclick', () => go(0, width));
    reset.addEventListener('click', () => go(0, width));
  }
  const fitAll = () => all.forEach(plot => plot.fit());
  fitAll();
  window.addEventListener('resize', fitAll);
  document.addEventListener('toggle', fitAll, true);
  for (const button of document.querySelectorAll('button.copy')) {
    button.addEventListener('click', () => {
      const text = button.parentNode.querySelector('pre').textContent;
      const done = () => { button.textContent = 'copied'; };
      if (navigator.clipboard) navigator.clipboard.writeText(text).then(done, () => {});
    });
  }
  window.plots = all;
})();
