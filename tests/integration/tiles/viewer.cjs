// Shows a tileset in a viewer in headless Chromium and compares its picture with one of `lodestream render`:
//   node viewer.cjs three|cesium '{"url", "eye", "target", "up", "fov_y_deg", "picture"}'
// Prints one JSON object: tiles, triangles, cover (pixels of the model, then those that only one picture has), psnr_db, errors.
// Exits with 77 if a package or Chromium is missing.
const fs = require('fs'), http = require('http'), path = require('path');

const [viewer, json] = process.argv.slice(2);
const packages = { three: ['three', '3d-tiles-renderer'], cesium: ['cesium'] }[viewer];
const WIDTH = 1280, HEIGHT = 720, BACKGROUND = '#202428';

function folderOf(name) {
  const folder = (process.env.NODE_PATH || '').split(':').map((root) => path.join(root, name)).find((f) => fs.existsSync(f));
  if (!folder) skip(`NODE_PATH has no ${name}`);
  return folder;
}

function skip(reason) {
  console.error(reason);
  process.exit(77);
}

const pages = {
  three: `<script type="importmap">{ "imports": { "three": "/three/build/three.module.js", "three/examples/": "/three/examples/",
    "three/addons/": "/three/examples/jsm/",
    "3d-tiles-renderer/three": "/3d-tiles-renderer/build/index.three.js",
    "3d-tiles-renderer/three/plugins": "/3d-tiles-renderer/build/index.three-plugins.js" } }</script>
  <script type="module">
    import * as THREE from 'three';
    import { DRACOLoader } from 'three/examples/jsm/loaders/DRACOLoader.js';
    import { TilesRenderer } from '3d-tiles-renderer/three';
    import { GLTFExtensionsPlugin } from '3d-tiles-renderer/three/plugins';
    const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    renderer.setSize(${WIDTH}, ${HEIGHT});
    renderer.setClearColor('${BACKGROUND}');
    const camera = new THREE.PerspectiveCamera(view.fov_y_deg, ${WIDTH} / ${HEIGHT}, 0.01, 1000), scene = new THREE.Scene();
    const tiles = new TilesRenderer(view.url);
    const dracoLoader = new DRACOLoader().setDecoderPath('/three/examples/jsm/libs/draco/gltf/');
    tiles.registerPlugin(new GLTFExtensionsPlugin({ dracoLoader }));
    tiles.errorTarget = 1;
    tiles.addEventListener('load-model', (loaded) => loaded.scene.traverse((mesh) => {
      if (mesh.isMesh) mesh.material = new THREE.MeshBasicMaterial({ vertexColors: true, side: THREE.DoubleSide });
    }));
    tiles.addEventListener('load-error', ({ error }) => errors.push(String(error)));
    camera.up.set(...view.up);
    camera.position.set(...view.eye);
    camera.lookAt(...view.target);
    camera.updateMatrixWorld();
    tiles.setCamera(camera);
    tiles.setResolutionFromRenderer(camera, renderer);
    scene.add(tiles.group);
    let idle = 0;
    renderer.setAnimationLoop(() => {
      tiles.update();
      renderer.render(scene, camera);
      idle = tiles.visibleTiles.size > 0 && tiles.stats.queued + tiles.stats.downloading + tiles.stats.parsing === 0 ? idle + 1 : 0;
      if (idle === 10) finish(renderer.domElement, tiles.visibleTiles.size, renderer.info.render.triangles);
    });
  </script>`,
  cesium: `<script>window.CESIUM_BASE_URL = '/cesium/Build/Cesium/'</script><script src="/cesium/Build/Cesium/Cesium.js"></script>
  <link rel="stylesheet" href="/cesium/Build/Cesium/Widgets/widgets.css">
  <div id="view" style="width: ${WIDTH}px; height: ${HEIGHT}px"></div>
  <script type="module">
    const widget = new Cesium.CesiumWidget('view', { globe: false, baseLayer: false, skyBox: false, skyAtmosphere: false,
      msaaSamples: 4, contextOptions: { webgl: { preserveDrawingBuffer: true } } });
    const { scene, camera } = widget, vector = (values) => new Cesium.Cartesian3(...values);
    scene.backgroundColor = Cesium.Color.fromCssColorString('${BACKGROUND}');
    const tileset = await Cesium.Cesium3DTileset.fromUrl(view.url,
      { maximumScreenSpaceError: 1, dynamicScreenSpaceError: false, foveatedScreenSpaceError: false });
    tileset.customShader = new Cesium.CustomShader({ lightingModel: Cesium.LightingModel.UNLIT });
    tileset.tileFailed.addEventListener(({ message }) => errors.push(message));
    scene.primitives.add(tileset);
    const unit = (v) => Cesium.Cartesian3.normalize(v, v), cross = (a, b) => Cesium.Cartesian3.cross(a, b, vector([0, 0, 0]));
    camera.frustum.fov = 2 * Math.atan(Math.tan(view.fov_y_deg * Math.PI / 360) * ${WIDTH} / ${HEIGHT});
    camera.frustum.near = 0.01;
    camera.position = vector(view.eye);
    camera.direction = unit(vector(view.target.map((value, axis) => value - view.eye[axis])));
    camera.right = unit(cross(camera.direction, vector(view.up)));
    camera.up = cross(camera.right, camera.direction);
    let idle = 0;
    setInterval(() => {  // CesiumJS requests nothing for a while after its camera has moved
      idle = tileset.tilesLoaded ? idle + 1 : 0;
      const { selected, numberOfTrianglesSelected } = tileset.statistics;
      if (idle === 10) finish(scene.canvas, selected, numberOfTrianglesSelected);
    }, 200);
  </script>`,
};

// Runs in the page. The background of `render` is constant in each row, and the first column shows no model.
async function finish(canvas, tiles, triangles) {
  const texels = (image) => {
    const copy = Object.assign(document.createElement('canvas'), { width: canvas.width, height: canvas.height });
    const context = copy.getContext('2d');
    context.drawImage(image, 0, 0);
    return context.getImageData(0, 0, copy.width, copy.height).data;
  };
  const shown = texels(canvas), picture = new Image();
  picture.src = '/picture.png';
  await picture.decode();
  const expected = texels(picture), cover = [0, 0];
  let both = 0, squares = 0;
  const isModel = (data, at, first) => [0, 1, 2].some((i) => Math.abs(data[at + i] - data[first + i]) > 3);
  for (let at = 0; at < shown.length; at += 4) {
    const first = at - at % (4 * canvas.width), a = isModel(shown, at, first), b = isModel(expected, at, first);
    cover[0] += b ? 1 : 0;
    cover[1] += a !== b ? 1 : 0;
    if (!a || !b) continue;
    ++both;
    for (let i = 0; i < 3; ++i) squares += (shown[at + i] - expected[at + i]) ** 2 / 3;
  }
  window.result ??= { tiles, triangles, cover, psnr_db: 10 * Math.log10(255 ** 2 * both / squares) };
}

(async () => {
  const view = JSON.parse(json), roots = Object.fromEntries(packages.map((name) => [name, folderOf(name)]));
  const { chromium } = require(folderOf('playwright-core'));
  const program = ['/usr/bin/chromium', '/usr/bin/chromium-browser'].find((file) => fs.existsSync(file));
  if (!program) skip('Chromium is not installed');
  const types = { '.js': 'text/javascript', '.wasm': 'application/wasm', '.json': 'application/json', '.css': 'text/css' };
  const server = http.createServer((request, response) => {
    const [, root, rest] = request.url.split('?')[0].match(/^\/([^/]*)\/?(.*)$/);
    const file = root === 'picture.png' ? view.picture : roots[root] && path.join(roots[root], rest);
    const found = root === '' || (file && fs.existsSync(file));
    response.writeHead(found ? 200 : 404, { 'content-type': root === '' ? 'text/html' : types[path.extname(file || '')] || '' });
    response.end(root === '' ? `<!doctype html><style>body { margin: 0 }</style><script>const view = ${json}, errors = [];
      ${finish}</script>${pages[viewer]}` : found ? fs.readFileSync(file) : '');
  });
  await new Promise((done) => server.listen(0, '127.0.0.1', done));
  const browser = await chromium.launch({ executablePath: program, args: ['--no-sandbox', '--use-gl=angle',
    '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'] });
  const page = await browser.newPage({ viewport: { width: WIDTH, height: HEIGHT } }), thrown = [];
  const failed = new Promise((done) => page.on('pageerror', (error) => done(thrown.push(error.message))));
  await page.goto(`http://127.0.0.1:${server.address().port}/`);
  const finished = page.waitForFunction('window.result || errors.length', null, { timeout: 300000, polling: 500 });
  await Promise.race([finished.catch((error) => thrown.push(error.message)), failed]);
  const result = await page.evaluate('({ ...window.result, errors })');
  console.log(JSON.stringify({ ...result, errors: [...result.errors, ...thrown] }));
  await browser.close();
  server.close();
})();
