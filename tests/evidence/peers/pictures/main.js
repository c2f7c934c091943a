// Draws one view: `window.scene` has the volume's file and dimensions, the camera and the colours
// (tests/bench/pictures/browser_peers.ts), and the name of the program. Marks "picture" when it is drawn.
const { scene } = window;
const values = new Uint8Array(await (await fetch(scene.file)).arrayBuffer());
const programs = { vtk_js: () => import("./vtk_js.js"), niivue: () => import("./niivue.js") };
const { draw } = await programs[scene.program]();
await draw(scene, values, document.getElementById("view"));
performance.mark("picture");
