'use strict';
// Draws a page's charts with Chart.js, from the JSON that charts/chart_json.cpp writes. Chart.js only gets linear axes:
// logarithms are computed here, so that a logarithmic axis can show zeros beside it, and all axes choose their ticks in
// the same way when they are zoomed.
(() => {
  // The palette of M. Okabe and K. Ito, Color Universal Design, 2008, as in charts/chart_svg.cpp.
  const LIGHT = ['#0072B2', '#D55E00', '#009E73', '#E69F00', '#CC79A7', '#56B4E9', '#1f2328', '#F0E442'];
  const DARK = ['#3D9BDC', '#E8762B', '#12B886', '#E69F00', '#CC79A7', '#7CC8F2', '#e6edf3', '#F0E442'];
  const DASHES = [[], [7, 3], [2.5, 3], [10, 3, 2, 3], [5, 2, 2, 2, 2, 2], [12, 4], [], [4, 4]];
  const SHAPES = ['circle', 'rect', 'rectRot', 'triangle', 'triangle', 'rectRounded', 'circle', 'rect'];
  const PREFIXES = [[1e12, 'T'], [1e9, 'G'], [1e6, 'M'], [1e3, 'k'], [1, ''], [1e-3, 'm'], [1e-6, 'µ'], [1e-9, 'n']];
  const FONT = {family: "Helvetica, Arial, 'Liberation Sans', sans-serif", size: 11.5};
  const dark = matchMedia('(prefers-color-scheme: dark)');
  const colours = () => dark.matches ? {palette: DARK, ink: '#e6edf3', muted: '#9aa4af', page: '#12161c', grid: '#262d36', axis: '#6e7681', band: '#1a2029'}
    : {palette: LIGHT, ink: '#1f2328', muted: '#59636e', page: '#ffffff', grid: '#e8ebef', axis: '#8b949e', band: '#f3f5f8'};

  const plain = value => String(Number(value.toPrecision(6)));
  // Formats a number with its unit, such as 10 µm, 1 ms or 45 k; with the unit %, 0.001 becomes 0.1 %.
  function numberText(value, unit) {
    if (unit === '%') return plain(value * 100) + ' %';
    const size = Math.abs(value), space = unit ? ' ' + unit : '';
    if (size === 0 || (size < 1 && !unit)) return plain(value) + space;
    const prefix = PREFIXES.find(p => size >= p[0] * (1 - 1e-9));
    if (!prefix) return plain(value) + space;
    return plain(value / prefix[0]) + (prefix[1] + unit ? ' ' + prefix[1] + unit : '');
  }

  // Breaks text into lines of at most `most` characters.
  const wrapped = (text, most) => text.split(' ').reduce((lines, word) => {
    const last = lines.at(-1);
    return last && last.length + word.length < most ? [...lines.slice(0, -1), `${last} ${word}`] : [...lines, word];
  }, []);

  const niceStep = least => {
    const power = 10 ** Math.floor(Math.log10(least));
    return power * [1, 2, 5, 10].find(factor => factor * power >= least * (1 - 1e-9));
  };

  // Returns the logarithm of the largest number that is 1, 2 or 5 times a power of ten and whose logarithm is at most
  // `log`. For the smallest number whose logarithm is at least `log`, use -niceLog(-log).
  const niceLog = log => {
    const power = Math.floor(log + 1e-9), stops = [0, Math.log10(2), Math.log10(5)];
    return power + Math.max(...stops.filter(stop => power + stop <= log + 1e-9));
  };

  // An axis: its ends, its ticks, and the positions of values on it.
  class Axis {
    constructor(axis, values, fromZero) {
      Object.assign(this, axis);
      const finite = values.filter(v => v !== null && (!this.log || v > 0)).map(v => this.log ? Math.log10(v) : v);
      const given = [this.low, this.high].map(v => v === undefined ? undefined : this.log ? Math.log10(v) : v);
      if (this.names) finite.push(-0.5, this.names.length - 0.5);
      if (fromZero && !this.log) finite.push(0);
      if (!finite.length) finite.push(0, 1);
      let low = Math.min(...finite), high = Math.max(...finite);
      if (!this.names) {
        if (!(high > low)) [low, high] = this.log || low === 0 ? [low - 1, high + 1] : [low - Math.abs(low) * 0.1, high + Math.abs(high) * 0.1];
        const pad = 0.04 * (high - low), zero = !this.log && low >= 0;
        low = fromZero && low === 0 ? 0 : low - pad;
        high += pad;
        if (zero) low = Math.max(low, 0);
        if (this.log) [low, high] = [niceLog(low), -niceLog(-high)];
        if (given[0] !== undefined && given[0] <= Math.min(...finite)) low = given[0];
        if (given[1] !== undefined && given[1] >= Math.max(...finite)) high = given[1];
      }
      this.band = this.log && values.some(v => v !== null && v <= 0) ? low : undefined;
      if (this.band !== undefined) low -= 0.1 * (high - low);
      this.min = low;
      this.max = high;
    }
    place(value) {
      if (value === null) return NaN;
      return !this.log ? value : value > 0 ? Math.log10(value) : (this.min + this.band) / 2;
    }
    text(place) {
      if (this.names) return this.names[place] ?? '';
      if (this.band !== undefined && place < this.band) return this.zero;
      return numberText(this.log ? 10 ** place : place, this.unit);
    }
    ticks(min, max, most) {
      if (this.names) return this.names.map((_, i) => i).filter(i => i >= min && i <= max);
      const places = this.band !== undefined && this.place(0) >= min ? [this.place(0)] : [];
      const from = Math.max(min, this.band ?? min);
      if (!this.log || max - from < 0.5) {
        const at = v => this.log ? 10 ** v : v;
        const step = niceStep((at(max) - at(from)) / most);
        for (let i = Math.ceil(at(from) / step - 1e-9); i * step <= at(max) * (1 + 1e-9) + step * 1e-9; ++i) {
          if (!this.log || i > 0) places.push(this.log ? Math.log10(i * step) : Number((i * step).toPrecision(12)));
        }
        return places;
      }
      const decades = Math.ceil((max - from) / most), digits = (max - from) * 3 <= most ? [1, 2, 5] : [1];
      for (let decade = Math.floor(from); decade <= max; ++decade) {
        if (decade % decades !== 0) continue;
        for (const digit of digits) {
          const place = decade + Math.log10(digit);
          if (place >= from - 1e-9 && place <= max + 1e-9) places.push(place);
        }
      }
      return places;
    }
  }

  const marksOf = chart => chart.data.datasets.flatMap((set, s) => !chart.isDatasetVisible(s) ? [] :
    chart.getDatasetMeta(s).data.map((element, i) => ({set, element, i})).filter(m => !m.element.skip && Number.isFinite(m.element.x) && Number.isFinite(m.element.y)));

  // Draws the band for zeros, error bars, labels beside points if there is room, and the frame while the user zooms.
  const extras = {
    id: 'extras',
    beforeDatasetsDraw(chart) {
      const {ctx, chartArea: area, scales} = chart, c = colours();
      ctx.fillStyle = c.band;
      for (const [axis, scale] of [[chart.axes.x, scales.x], [chart.axes.y, scales.y]]) {
        if (axis.band === undefined || scale.min > axis.band) continue;
        const end = scale.getPixelForValue(axis.band);
        if (scale === scales.x) ctx.fillRect(area.left, area.top, end - area.left, area.bottom - area.top);
        else ctx.fillRect(area.left, end, area.right - area.left, area.bottom - end);
      }
      ctx.save();
      ctx.beginPath();
      ctx.rect(area.left, area.top, area.right - area.left, area.bottom - area.top);
      ctx.clip();
      for (const {set, element, i} of marksOf(chart)) {
        const span = set.spans?.[i];
        if (!span || span[0] === null || span[1] === null) continue;
        const [low, high] = span.map(v => scales.y.getPixelForValue(chart.axes.y.place(v))), x = element.x;
        ctx.strokeStyle = set.borderColor;
        ctx.lineWidth = 1.3;
        ctx.beginPath();
        for (const [x0, y0, x1, y1] of [[x, low, x, high], [x - 4, low, x + 4, low], [x - 4, high, x + 4, high]]) {
          ctx.moveTo(x0, y0);
          ctx.lineTo(x1, y1);
        }
        ctx.stroke();
      }
      ctx.restore();
    },
    afterDatasetsDraw(chart) {
      const {ctx, chartArea: area} = chart, c = colours(), marks = marksOf(chart).filter(m => m.element.x >= area.left - 1 && m.element.x <= area.right + 1);
      const rank = set => set.first ? 0 : set.strong ? 1 : 2;
      const taken = marks.filter(m => m.set.type !== 'bar' && m.element.options.radius > 0)
        .map(({element: e}) => [e.x - e.options.radius, e.y - e.options.radius, e.x + e.options.radius, e.y + e.options.radius]);
      // The boxes of the steps of emphasised lines, which are staircases. Labels avoid them if possible.
      const lines = chart.data.datasets.flatMap((set, s) => !set.strong || !set.showLine || !chart.isDatasetVisible(s) ? [] :
        chart.getDatasetMeta(s).data.slice(1).map((e, i) => [e, chart.getDatasetMeta(s).data[i]])
          .map(([a, b]) => [Math.min(a.x, b.x), Math.min(a.y, b.y), Math.max(a.x, b.x) + 1, Math.max(a.y, b.y) + 1]));
      const overlaps = (a, b) => a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];
      ctx.textBaseline = 'middle';
      ctx.lineJoin = 'round';
      for (const {set, element, i} of marks.filter(m => m.set.texts?.[m.i]).sort((a, b) => rank(a.set) - rank(b.set))) {
        const text = set.texts[i], bar = set.type === 'bar', lying = chart.options.indexAxis === 'y';
        ctx.font = `${set.strong ? 600 : 400} ${FONT.size}px ${FONT.family}`;
        const half = ctx.measureText(text).width / 2, off = bar ? 3 : element.options.radius + 3;
        const sides = bar ? [lying ? [1, 0] : [0, -1]] : [[1, 0], [-1, 0], [0, -1], [0, 1], [1, -1], [1, 1], [-1, -1], [-1, 1]];
        const reaches = bar ? [0] : set.first || set.strong ? [0, 10, 22, 36] : [0, 8];
        let place, second;
        for (const [dx, dy, more] of reaches.flatMap(more => sides.map(side => [...side, more]))) {
          const x = element.x + dx * (off + more + half), y = element.y + dy * (off + more + 7);
          const box = [x - half, y - 7, x + half, y + 7];
          const inside = box[0] >= area.left && box[2] <= area.right + (bar ? 8 : 0) && box[1] >= area.top - 2 && box[3] <= area.bottom;
          if (!inside || taken.some(other => overlaps(box, other))) continue;
          second ??= {x, y, box, more};
          if (!lines.some(other => overlaps(box, other))) {
            place = {x, y, box, more};
            break;
          }
        }
        place ??= second;
        if (!place) continue;
        taken.push(place.box);
        if (place.more > 8) {
          ctx.strokeStyle = c.axis;
          ctx.lineWidth = 0.8;
          ctx.beginPath();
          ctx.moveTo(element.x, element.y);
          ctx.lineTo(Math.min(Math.max(element.x, place.box[0]), place.box[2]), Math.min(Math.max(element.y, place.box[1]), place.box[3]));
          ctx.stroke();
        }
        ctx.strokeStyle = c.page;
        ctx.lineWidth = 2.5;
        ctx.strokeText(text, place.x - half, place.y);
        ctx.fillStyle = c.ink;
        ctx.fillText(text, place.x - half, place.y);
      }
      if (chart.frame) {
        ctx.strokeStyle = ctx.fillStyle = c.palette[0];
        ctx.strokeRect(...chart.frame);
        ctx.globalAlpha = 0.15;
        ctx.fillRect(...chart.frame);
        ctx.globalAlpha = 1;
      }
    },
  };

  function datasetOf(series, chart, axes, someStrong) {
    const c = colours(), colour = c.palette[series.color % 8], lying = Boolean(chart.y.names);
    const faded = someStrong && !series.strong ? colour + '99' : colour;
    const set = {
      label: series.name, strong: series.strong, first: series.first, spans: series.spans, texts: series.labels, details: series.details,
      data: series.points.map(p => ({x: axes.x.place(p[0]), y: axes.y.place(p[1])})),
      borderColor: faded, backgroundColor: colour, order: series.strong ? 0 : 1, clip: 8,
    };
    if (series.mark === 'bars') {
      const value = lying ? axes.x : axes.y;
      return {...set, type: 'bar', order: 2, ...value.log && {base: value.min}, backgroundColor: series.points.map((_, i) => series.fills?.[i] ?? colour),
        borderWidth: 0, categoryPercentage: 0.78, barPercentage: 0.95, maxBarThickness: 26};
    }
    const line = series.mark !== 'dots', radius = series.mark === 'line' ? 0 : (series.strong ? 6.5 : 4.5) * (series.color % 6 ? 1.2 : 1);
    return {...set, type: 'line', showLine: line, borderDash: DASHES[series.color % 8], borderWidth: series.strong ? 2.4 : 1.8,
      pointStyle: SHAPES[series.color % 8], pointRotation: series.color % 8 === 4 ? 180 : 0, pointRadius: radius, pointHoverRadius: radius + 2,
      pointHitRadius: 6, pointBackgroundColor: colour, pointBorderColor: c.page, pointBorderWidth: radius ? 1 : 0};
  }

  // For each name, adds a button that hides and shows the series with this name.
  function legend(figure, chart, series) {
    let box = figure.querySelector('.legend');
    if (!box) figure.querySelector('figcaption').after(box = document.createElement('div'));
    box.className = 'legend';
    const entries = new Map();
    series.forEach((s, i) => {
      if (s.name && s.points.some(p => p[0] !== null && p[1] !== null)) {
        const key = s.name + '\n' + s.color;
        entries.set(key, [...entries.get(key) ?? [], i]);
      }
    });
    box.replaceChildren(...[...entries.values()].map(own => {
      const button = document.createElement('button'), key = document.createElement('i'), first = series[own[0]];
      key.style.background = first.fills?.[0] ?? colours().palette[first.color % 8];
      key.className = own.some(i => series[i].mark === 'bars') ? 'bar' : own.every(i => series[i].mark === 'line') ? 'line' : '';
      button.append(key, first.name);
      button.type = 'button';
      button.title = 'click to hide or show';
      button.setAttribute('aria-pressed', 'true');
      button.addEventListener('click', () => {
        const shown = !chart.isDatasetVisible(own[0]);
        own.forEach(i => chart.setDatasetVisibility(i, shown));
        button.setAttribute('aria-pressed', String(shown));
        chart.update('none');
      });
      return button;
    }));
  }

  // Handles zooming: dragging zooms to a frame, the wheel zooms around the pointer after a click on the chart, and a
  // double click shows everything again.
  function zoom(canvas, chart) {
    const set = (x, y) => {
      Object.assign(chart.options.scales.x, {min: x[0], max: x[1]});
      Object.assign(chart.options.scales.y, {min: y[0], max: y[1]});
      chart.update('none');
    };
    const sorted = (a, b) => a < b ? [a, b] : [b, a];
    let from = null;
    canvas.tabIndex = 0;
    canvas.onpointerdown = event => {
      if (event.button === 0 && event.pointerType === 'mouse') from = [event.offsetX, event.offsetY];
    };
    canvas.onpointermove = event => {
      if (!from) return;
      chart.frame = [from[0], from[1], event.offsetX - from[0], event.offsetY - from[1]];
      chart.draw();
    };
    canvas.onpointerup = canvas.onpointerleave = event => {
      const to = [event.offsetX, event.offsetY], wide = from && event.type === 'pointerup' && Math.abs(to[0] - from[0]) > 8 && Math.abs(to[1] - from[1]) > 8;
      if (wide) {
        const {x, y} = chart.scales;
        set(sorted(x.getValueForPixel(from[0]), x.getValueForPixel(to[0])), sorted(y.getValueForPixel(from[1]), y.getValueForPixel(to[1])));
      } else if (from) chart.draw();
      from = chart.frame = null;
      if (wide) chart.draw();
    };
    canvas.ondblclick = () => set([chart.axes.x.min, chart.axes.x.max], [chart.axes.y.min, chart.axes.y.max]);
    canvas.addEventListener('wheel', event => {
      if (document.activeElement !== canvas) return;
      event.preventDefault();
      const factor = event.deltaY > 0 ? 1.2 : 1 / 1.2;
      const about = (scale, pixel) => {
        const at = scale.getValueForPixel(pixel);
        return [at + (scale.min - at) * factor, at + (scale.max - at) * factor];
      };
      set(about(chart.scales.x, event.offsetX), about(chart.scales.y, event.offsetY));
    }, {passive: false});
  }

  function draw(figure) {
    const chart = JSON.parse(figure.querySelector('script').textContent), canvas = figure.querySelector('canvas'), c = colours();
    const all = k => chart.series.flatMap(s => s.points.map(p => p[k]));
    const lying = Boolean(chart.y.names), bars = chart.series.some(s => s.mark === 'bars');
    const ends = k => {  // ends of the stacked bars on axis k
      const sums = new Map();
      return chart.series.flatMap(s => s.points.map(p => {
        sums.set(p[1 - k], (sums.get(p[1 - k]) ?? 0) + p[k]);
        return sums.get(p[1 - k]);
      }));
    };
    // Extend the axis, to leave space for the labels beyond the ends of bars.
    const labelled = k => !bars || chart.x.log || chart.y.log || !chart.series.some(s => s.labels) ? [] : (chart.stacked ? ends(k) : all(k)).map(v => v * 1.12);
    const values = k => [...all(k), ...(k === (lying ? 0 : 1) ? [...labelled(k), ...(chart.stacked ? ends(k) : [])] : []),
      ...(k === 1 ? chart.series.flatMap(s => s.spans?.flat() ?? []) : [])];
    const axes = {x: new Axis(chart.x, values(0), bars && lying), y: new Axis(chart.y, values(1), bars && !lying)};
    const someStrong = chart.series.some(s => s.strong);
    const letters = (canvas.parentElement.clientWidth - (lying ? 130 : 60)) / 7;  // number of characters that fit beside an axis, for its title
    const scale = (axis, pixelsPerTick) => ({
      type: 'linear', bounds: 'data', offset: false, min: axis.min, max: axis.max, reverse: axis === axes.y && lying, stacked: chart.stacked,
      title: {display: axis === axes.x && Boolean(axis.title), text: wrapped(axis.title ?? '', letters), color: c.muted, font: {...FONT, size: 12}},
      grid: {color: axis.names && axis === axes.x ? 'transparent' : c.grid, borderColor: c.axis, tickColor: c.axis, offset: false},
      ticks: {color: c.ink, font: FONT, autoSkip: axis === axes.x && !axis.names, maxRotation: axis.names ? 40 : 0, includeBounds: false,
        callback(value) {
          // Long names are shortened in the middle, since names often differ only at their end.
          const text = axis.text(value), room = this.chart.width < 450 ? 22 : this.chart.width < 700 ? 30 : 40;
          return text.length > room ? text.slice(0, room - 11) + '…' + text.slice(-10) : text;
        }},
      afterBuildTicks: own => {
        const length = axis === axes.x ? own.chart.width - 60 : own.chart.height - 40;
        const places = axis.ticks(own.min, own.max, Math.max(2, length / pixelsPerTick));
        // The label for zero must not overlap a number.
        const pixels = (length - (axis === axes.x && lying ? 110 : 0)) / (own.max - own.min), room = axis === axes.x ? 45 : 14;
        const hides = v => places[0] < axis.band && v > places[0] && (v - places[0]) * pixels < room;
        own.ticks = places.filter(v => !hides(v)).map(value => ({value}));
      },
    });
    Chart.getChart(canvas)?.destroy();
    const made = new Chart(canvas, {
      data: {datasets: chart.series.map(s => datasetOf(s, chart, axes, someStrong))},
      options: {
        animation: false, responsive: true, maintainAspectRatio: false, indexAxis: lying ? 'y' : 'x', normalized: false,
        layout: {padding: {right: 12, top: 6}},
        interaction: {mode: 'nearest', intersect: true},
        scales: {x: scale(axes.x, 75), y: scale(axes.y, 32)},
        plugins: {legend: {display: false}, tooltip: {displayColors: false, callbacks: {
          title: () => '',
          label: ({dataset, dataIndex, raw}) => (dataset.details?.[dataIndex] ||
            `${dataset.label ? dataset.label + ': ' : ''}${axes.x.text(raw.x)}, ${axes.y.text(raw.y)}`).split('\n'),
        }}},
      },
      plugins: [{id: 'axes', beforeInit: own => { own.axes = axes; }}, extras],
    });
    legend(figure, made, chart.series);
    zoom(canvas, made);
  }

  const drawAll = () => document.querySelectorAll('figure.chart').forEach(draw);
  drawAll();
  dark.addEventListener('change', drawAll);
})();
