// Draws the point clouds of a dataset's report with three.js. scan_view.h describes the data.
(function () {
  'use strict';
  var element = function (id) { return document.getElementById(id); };
  var source = element('scan-data');
  if (!source) return;
  var data = JSON.parse(source.textContent);
  var canvas = element('sv-canvas'), stage = canvas.parentElement;

  // ---- decoding ----

  var bytesOf = function (text) {
    var raw = atob(text), bytes = new Uint8Array(raw.length);
    for (var i = 0; i < raw.length; ++i) bytes[i] = raw.charCodeAt(i);
    return bytes;
  };
  // The data are little-endian, and so are all machines that run browsers.
  var numbersOf = function (column) {
    var bytes = bytesOf(column.data);
    if (column.type === 'u8') return bytes;
    return column.type === 'u16' ? new Uint16Array(bytes.buffer) : new Uint32Array(bytes.buffer);
  };
  var kNone = 65535;  // code in a column of values: there is no value
  var valuesOf = function (column) {
    var numbers = numbersOf(column), values = new Float32Array(numbers.length);
    for (var i = 0; i < numbers.length; ++i) {
      values[i] = !column.whole && numbers[i] === kNone ? NaN : column.low + column.step * numbers[i];
    }
    return values;
  };
  var decode = function (scan) {
    var places = numbersOf(scan.position), n = scan.shown;
    var made = {scan: scan, count: n, xyz: new Float32Array(3 * n), values: []};
    var range = new Float32Array(n), height = new Float32Array(n);
    for (var i = 0; i < n; ++i) {
      for (var c = 0; c < 3; ++c) made.xyz[3 * i + c] = scan.box.low[c] + scan.box.step[c] * places[3 * i + c];
      range[i] = Math.hypot(made.xyz[3 * i], made.xyz[3 * i + 1], made.xyz[3 * i + 2]);
      height[i] = made.xyz[3 * i + 2];
    }
    made.classOf = scan['class'] ? numbersOf(scan['class']) : null;
    made.instanceOf = scan.instance ? numbersOf(scan.instance) : null;
    scan.values.forEach(function (column) {
      made.values.push({name: column.name, unit: column.unit, at: valuesOf(column)});
    });
    made.values.push({name: 'range', unit: 'm', at: range}, {name: 'height', unit: 'm', at: height});
    return made;
  };

  // ---- colours ----

  var css = function (rgb) { return 'rgb(' + rgb.join(',') + ')'; };
  // The colour scale covers the 1st to the 99th percentile; values beyond get the colours of its ends.
  var scaleOf = function (column) {
    var sorted = column.at.filter(function (v) { return !isNaN(v); }).sort();
    var at = function (share) { return sorted.length ? sorted[Math.round(share * (sorted.length - 1))] : 0; };
    // Intensity decreases with the square of the distance, so its square root is shown.
    return {low: at(0.01), high: at(0.99), power: column.name === 'intensity' ? 2 : 1};
  };
  var choices = function (cloud) {
    var list = [];
    if (cloud.classOf) list.push('class');
    if (cloud.instanceOf) list.push('instance');
    return list.concat(cloud.values.map(function (v) { return v.name; }));
  };
  var paint = function (cloud, choice) {
    var rgb = new Uint8Array(3 * cloud.count);
    var put = function (i, color) { rgb[3 * i] = color[0]; rgb[3 * i + 1] = color[1]; rgb[3 * i + 2] = color[2]; };
    var i, last = data.viridis.length - 1;
    element('sv-scale').textContent = '';
    if (choice === 'class') {
      for (i = 0; i < cloud.count; ++i) put(i, cloud.scan.classes[cloud.classOf[i]].color);
    } else if (choice === 'instance') {
      for (i = 0; i < cloud.count; ++i) put(i, cloud.scan.instances.colors[cloud.instanceOf[i]]);
    } else {
      var column = cloud.values.filter(function (v) { return v.name === choice; })[0], scale = scaleOf(column);
      for (i = 0; i < cloud.count; ++i) {
        var t = scale.high > scale.low ? (column.at[i] - scale.low) / (scale.high - scale.low) : 0;
        t = Math.pow(Math.min(Math.max(t, 0), 1), 1 / scale.power);
        put(i, isNaN(t) ? data.none : data.viridis[Math.round(t * last)]);
      }
      showScale(column, scale);
    }
    return rgb;
  };
  var textOf = function (value, digits) { return String(Number(value.toFixed(digits))); };
  var showScale = function (column, scale) {
    var box = element('sv-scale'), bar = document.createElement('i'), ends = document.createElement('span');
    box.appendChild(document.createTextNode(column.name + (column.unit ? ' (' + column.unit + ')' : '')));
    bar.style.background = 'linear-gradient(to right,' + data.viridis.map(css).join(',') + ')';
    [scale.low, scale.high].forEach(function (value) {
      var end = document.createElement('b');
      end.textContent = textOf(value, Math.abs(value) < 10 ? 2 : 0);
      ends.appendChild(end);
    });
    box.appendChild(bar);
    box.appendChild(ends);
  };

  // ---- the drawing ----

  var give = function (why) {
    canvas.style.display = 'none';
    var text = element('sv-nothing');
    text.hidden = false;
    text.textContent = why;
    document.body.dataset.scanView = 'unavailable';
  };
  var renderer;
  try {
    renderer = new THREE.WebGLRenderer({canvas: canvas, antialias: false});
  } catch (error) {
    give('This browser offers no WebGL, which turning points about needs. The pictures above show the same scans.');
    return;
  }
  var background = new THREE.Color(data.background[0] / 255, data.background[1] / 255, data.background[2] / 255);
  renderer.setClearColor(background, 1);
  renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
  var scene = new THREE.Scene();
  var camera = new THREE.PerspectiveCamera(55, 1, 0.1, 4000);
  camera.up.set(0, 0, 1);
  var controls = new THREE.OrbitControls(camera, canvas);
  controls.enableKeys = false;
  controls.screenSpacePanning = true;
  controls.minDistance = 0.5;
  controls.maxDistance = 1500;
  // A click must not scroll the page to the picture. The wheel zooms only after a click; before, it scrolls the page.
  canvas.focus = function () { HTMLElement.prototype.focus.call(canvas, {preventScroll: true}); };
  controls.enableZoom = false;
  canvas.addEventListener('focus', function () { controls.enableZoom = true; });
  canvas.addEventListener('blur', function () { controls.enableZoom = false; });

  // Draws points as discs. `size` is their diameter in pixels at a distance of 20 m; nearer points are larger.
  var material = new THREE.ShaderMaterial({
    uniforms: {size: {value: 2.5}, ratio: {value: 1}},
    vertexShader: 'attribute vec3 tint; varying vec3 shade; uniform float size; uniform float ratio;' +
      'void main() { shade = tint; vec4 seen = modelViewMatrix * vec4(position, 1.0);' +
      'gl_PointSize = ratio * clamp(size * 20.0 / max(-seen.z, 0.1), max(size * 0.5, 1.0), size * 4.0);' +
      'gl_Position = projectionMatrix * seen; }',
    fragmentShader: 'varying vec3 shade; void main() { vec2 off = gl_PointCoord - vec2(0.5);' +
      'if (dot(off, off) > 0.25) discard; gl_FragColor = vec4(shade, 1.0); }'
  });
  var pointSize = function (depth) {  // the size that the shader computes, in CSS pixels
    var size = material.uniforms.size.value;
    return Math.min(Math.max(size * 20 / Math.max(depth, 0.1), Math.max(size * 0.5, 1)), size * 4);
  };
  var marker = new THREE.Points(new THREE.BufferGeometry(), new THREE.ShaderMaterial({
    depthTest: false, transparent: true, uniforms: {ratio: {value: 1}},
    vertexShader: 'uniform float ratio; void main() { gl_PointSize = 18.0 * ratio;' +
      'gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }',
    fragmentShader: 'void main() { float r = length(gl_PointCoord - vec2(0.5));' +
      'if (r > 0.5 || r < 0.34) discard; gl_FragColor = vec4(1.0, 1.0, 1.0, 1.0); }'
  }));
  marker.geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(3), 3));
  marker.frustumCulled = false;
  marker.visible = false;
  var sensor = new THREE.AxesHelper(2);
  scene.add(sensor, marker);

  var clouds = data.scans.map(function () { return null; });
  var cloud = null, points = null, asked = false;
  var hidden = {}, classIds = {};  // keys: class ids; `hidden` applies to all scans
  data.scans.forEach(function (scan) {
    (scan.classes || []).forEach(function (entry) { classIds[entry.id] = true; });
  });
  var draw = function () {
    asked = false;
    renderer.render(scene, camera);
  };
  var redraw = function () {
    if (!asked) { asked = true; requestAnimationFrame(draw); }
  };
  controls.addEventListener('change', redraw);
  var fit = function () {
    var width = stage.clientWidth, height = stage.clientHeight;
    if (!width || !height) return;
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    material.uniforms.ratio.value = renderer.getPixelRatio();
    marker.material.uniforms.ratio.value = renderer.getPixelRatio();
    redraw();
  };
  window.addEventListener('resize', fit);

  // Moves the camera behind and above the sensor, or straight above it.
  var look = function (above) {
    if (above) {
      camera.position.set(0, -0.05, 90);  // above, with x to the right and y up
      controls.target.set(0, 0, 0);
    } else {
      camera.position.set(-17, 0, 9);
      controls.target.set(6, 0, -1);
    }
    controls.update();
    redraw();
  };

  var isVisible = function (i) { return !cloud.classOf || !hidden[cloud.scan.classes[cloud.classOf[i]].id]; };
  var filter = function () {
    var index = new Uint16Array(cloud.count), n = 0;
    for (var i = 0; i < cloud.count; ++i) if (isVisible(i)) index[n++] = i;
    points.geometry.setIndex(new THREE.BufferAttribute(index.slice(0, n), 1));
    redraw();
  };
  var recolor = function () {
    var tint = new THREE.BufferAttribute(paint(cloud, element('sv-color').value), 3, true);
    points.geometry.setAttribute('tint', tint);
    redraw();
  };

  // ---- picking ----

  var kReach = 9;  // maximum distance from the pointer in pixels
  // Returns a point's position in the canvas (pixels) and its depth (m); null if it is behind the camera.
  var placeOf = function (i, view, projection) {
    var e = view.elements, p = projection.elements, x = cloud.xyz[3 * i], y = cloud.xyz[3 * i + 1],
        z = cloud.xyz[3 * i + 2];
    var depth = -(e[2] * x + e[6] * y + e[10] * z + e[14]);
    if (depth < camera.near) return null;
    var sx = p[0] * (e[0] * x + e[4] * y + e[8] * z + e[12]) / depth;
    var sy = p[5] * (e[1] * x + e[5] * y + e[9] * z + e[13]) / depth;
    return {x: (sx + 1) / 2 * stage.clientWidth, y: (1 - sy) / 2 * stage.clientHeight, depth: depth};
  };
  // Returns the index of the point that is visible at a position; otherwise the nearest point around it; -1 if none.
  var pick = function (x, y) {
    camera.updateMatrixWorld();
    var view = new THREE.Matrix4().getInverse(camera.matrixWorld);
    var seen = -1, seenDepth = Infinity, near = -1, nearest = kReach * kReach;
    for (var i = 0; i < cloud.count; ++i) {
      if (!isVisible(i)) continue;
      var place = placeOf(i, view, camera.projectionMatrix);
      if (!place) continue;
      var off = (place.x - x) * (place.x - x) + (place.y - y) * (place.y - y), radius = pointSize(place.depth) / 2;
      if (off <= radius * radius && place.depth < seenDepth) { seen = i; seenDepth = place.depth; }
      if (off < nearest) { near = i; nearest = off; }
    }
    return seen >= 0 ? seen : near;
  };
  var describe = function (i) {
    var lines = [];
    if (cloud.classOf) lines.push('class ' + cloud.scan.classes[cloud.classOf[i]].name);
    if (cloud.instanceOf) {
      var id = cloud.scan.instances.ids[cloud.instanceOf[i]];
      lines.push(id === 0 ? 'no instance' : 'instance ' + id);
    }
    lines.push('x ' + cloud.xyz[3 * i].toFixed(2) + '  y ' + cloud.xyz[3 * i + 1].toFixed(2) + '  z ' +
               cloud.xyz[3 * i + 2].toFixed(2) + ' m');
    cloud.values.forEach(function (v) {
      if (v.name === 'height') return;
      lines.push(v.name + ' ' + (isNaN(v.at[i]) ? 'not known' : textOf(v.at[i], 2)) + (v.unit ? ' ' + v.unit : ''));
    });
    return lines.join('\n');
  };
  var kept = -1;
  var mark = function (i) {
    marker.visible = i >= 0;
    element('sv-point').textContent = i >= 0 ? describe(i) : '';
    if (i >= 0) {
      marker.geometry.attributes.position.array.set(cloud.xyz.subarray(3 * i, 3 * i + 3));
      marker.geometry.attributes.position.needsUpdate = true;
    }
    redraw();
  };
  var placeIn = function (event) {
    var box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  var pressed = null, pointer = null;
  canvas.addEventListener('mousedown', function (event) { pressed = placeIn(event); });
  canvas.addEventListener('mousemove', function (event) {
    if (event.buttons || kept >= 0) return;
    if (!pointer) {
      requestAnimationFrame(function () {
        mark(pick(pointer[0], pointer[1]));
        pointer = null;
      });
    }
    pointer = placeIn(event);
  });
  canvas.addEventListener('mouseleave', function () { if (kept < 0) mark(-1); });
  canvas.addEventListener('click', function (event) {
    var at = placeIn(event);
    if (pressed && Math.hypot(at[0] - pressed[0], at[1] - pressed[1]) > 4) return;  // the user has rotated the view
    var found = pick(at[0], at[1]);
    kept = found === kept ? -1 : found;
    mark(found);
  });

  // ---- the controls around the picture ----

  var showClasses = function () {
    var box = element('sv-classes');
    box.textContent = '';
    if (!cloud.classOf) return;
    cloud.scan.classes.forEach(function (entry) {
      var button = document.createElement('button'), swatch = document.createElement('i'),
          count = document.createElement('small');
      button.type = 'button';
      button.setAttribute('aria-pressed', String(!hidden[entry.id]));
      swatch.style.background = css(entry.color);
      count.textContent = entry.points.toLocaleString('en');
      button.append(swatch, entry.name, count);
      button.addEventListener('click', function (event) {
        // The second click of a double click is handled below.
        if (event.detail > 1) return;
        hidden[entry.id] = !hidden[entry.id];
        refresh();
      });
      button.addEventListener('dblclick', function () {
        var others = Object.keys(classIds).filter(function (id) { return Number(id) !== entry.id; });
        var alone = others.every(function (id) { return hidden[id]; });
        others.forEach(function (id) { hidden[id] = !alone; });
        hidden[entry.id] = false;
        refresh();
      });
      box.appendChild(button);
    });
  };
  var refresh = function () {
    element('sv-classes').querySelectorAll('button').forEach(function (button, k) {
      button.setAttribute('aria-pressed', String(!hidden[cloud.scan.classes[k].id]));
    });
    kept = -1;
    mark(-1);
    filter();
  };
  var option = function (select, value, text) {
    var made = document.createElement('option');
    made.value = value;
    made.textContent = text;
    select.appendChild(made);
  };
  var show = function (k) {
    if (!clouds[k]) clouds[k] = decode(data.scans[k]);
    cloud = clouds[k];
    if (points) {
      scene.remove(points);
      points.geometry.dispose();
    }
    var geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(cloud.xyz, 3));
    points = new THREE.Points(geometry, material);
    points.frustumCulled = false;
    scene.add(points);
    var select = element('sv-color'), before = select.value, offered = choices(cloud);
    select.textContent = '';
    offered.forEach(function (name) { option(select, name, name); });
    select.value = offered.indexOf(before) >= 0 ? before : offered[0];
    element('sv-thinned').textContent = cloud.count < cloud.scan.points ?
        cloud.count.toLocaleString('en') + ' of ' + cloud.scan.points.toLocaleString('en') +
        ' points, to keep this file small: near surfaces are thinned, far and small things are whole.' :
        cloud.count.toLocaleString('en') + ' points, all of the scan.';
    recolor();
    showClasses();
    refresh();
  };
  data.scans.forEach(function (scan, k) { option(element('sv-scan'), String(k), scan.title); });
  element('sv-scan').addEventListener('change', function () { show(Number(this.value)); });
  element('sv-color').addEventListener('change', recolor);
  element('sv-size').addEventListener('input', function () {
    material.uniforms.size.value = Number(this.value);
    redraw();
  });
  element('sv-reset').addEventListener('click', function () { look(false); });
  element('sv-above').addEventListener('click', function () { look(true); });
  fit();
  show(0);
  look(false);
  document.body.dataset.scanView = 'ready';
}());
