  // Stands at the end of scan_view.js, and tells in attributes of the body what that has drawn.
  var pixelsOf = function (rgb) {
    sensor.visible = false;
    renderer.render(scene, camera);
    var gl = renderer.getContext(), w = gl.drawingBufferWidth, h = gl.drawingBufferHeight;
    var pixels = new Uint8Array(4 * w * h), count = 0;
    gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    for (var i = 0; i < pixels.length; i += 4) {
      if (Math.abs(pixels[i] - rgb[0]) < 2 && Math.abs(pixels[i + 1] - rgb[1]) < 2 &&
          Math.abs(pixels[i + 2] - rgb[2]) < 2) ++count;
    }
    return count;
  };
  var report = document.body.dataset;
  camera.updateMatrixWorld();
  var view = new THREE.Matrix4().getInverse(camera.matrixWorld), first = -1, least = Infinity;
  for (var i = 0; i < cloud.count; ++i) {
    var place = placeOf(i, view, camera.projectionMatrix);
    var inside = place && place.x > 0 && place.y > 0 && place.x < stage.clientWidth && place.y < stage.clientHeight;
    if (inside && place.depth < least) { first = i; least = place.depth; }
  }
  if (first >= 0) {
    var at = placeOf(first, view, camera.projectionMatrix), box = canvas.getBoundingClientRect();
    // The page's pixels of three.js and of the arithmetic here must be the same.
    var projected = new THREE.Vector3(cloud.xyz[3 * first], cloud.xyz[3 * first + 1], cloud.xyz[3 * first + 2]);
    projected.project(camera);
    report.testOffset = String(Math.hypot((projected.x + 1) / 2 * stage.clientWidth - at.x,
                                          (1 - projected.y) / 2 * stage.clientHeight - at.y));
    report.testWanted = describe(first);
    report.testPicked = describe(pick(at.x, at.y));
    var where = {clientX: box.left + at.x, clientY: box.top + at.y};
    canvas.dispatchEvent(new MouseEvent('mousedown', where));
    canvas.dispatchEvent(new MouseEvent('click', where));
    report.testClicked = element('sv-point').textContent;
    kept = -1;
    mark(-1);
  }
  report.testRevision = THREE.REVISION;
  report.testPoints = String(points.geometry.index.count);
  if (cloud.classOf) {
    var most = 0;
    cloud.scan.classes.forEach(function (entry, k) {
      if (entry.points > cloud.scan.classes[most].points) most = k;
    });
    var chosen = cloud.scan.classes[most], button = element('sv-classes').querySelectorAll('button')[most];
    report.testClass = chosen.name;
    report.testBefore = String(pixelsOf(chosen.color));
    button.click();
    report.testHidden = String(pixelsOf(chosen.color));
    report.testLeft = String(points.geometry.index.count);
    // What is hidden stays so in another scan.
    show(data.scans.length - 1);
    report.testOther = String(points.geometry.index.count);
    show(0);
    button = element('sv-classes').querySelectorAll('button')[most];
    button.click();
    report.testAgain = String(pixelsOf(chosen.color));
    var press = function () { button.dispatchEvent(new MouseEvent('dblclick')); };
    press();
    report.testAlone = String(points.geometry.index.count);
    press();
    report.testAll = String(points.geometry.index.count);
  }
  // As the viewer looks from above: 10 m along x are to the right of the middle, along y up from it.
  look(true);
  camera.updateMatrixWorld();
  var turned = [new THREE.Vector3(10, 0, 0), new THREE.Vector3(0, 10, 0)].map(function (at) {
    at.project(camera);
    return (at.x * camera.aspect).toFixed(2) + ',' + at.y.toFixed(2);
  });
  report.testAbove = turned.join(' ');
  look(false);
