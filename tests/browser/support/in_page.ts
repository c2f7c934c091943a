/**
 * Functions that tests run in the page, independent of the program that drives the browser. Only a
 * function's source text is sent to the page, so it must not use anything outside itself.
 */

/** Loses the view's context; resolves when the page has received the event. */
export async function loseContext(): Promise<void> {
  const canvas = document.querySelector<HTMLCanvasElement>("canvas.view");
  const extension = canvas?.getContext("webgl2")?.getExtension("WEBGL_lose_context");
  if (!canvas || !extension) throw new Error("no context to lose");
  (window as unknown as { loss: WEBGL_lose_context }).loss = extension;
  const lost = new Promise((resolve) =>
    canvas.addEventListener("webglcontextlost", resolve, { once: true }),
  );
  extension.loseContext();
  await lost;
}

/** Restores the context that `loseContext` lost. */
export function restoreContext(): void {
  (window as unknown as { loss: WEBGL_lose_context }).loss.restoreContext();
}

/** Moves the panel's isovalue slider, as a visitor does. */
export function slideTo(isovalue: number): void {
  const slider = document.querySelector<HTMLInputElement>(".isovalue-slider");
  if (!slider) throw new Error("no slider");
  slider.valueAsNumber = isovalue;
  slider.dispatchEvent(new Event("input", { bubbles: true }));
}

/** Drags the slider over its whole range, one isovalue a frame. Returns the seconds that it took. */
export async function dragOverRange(seconds: number): Promise<number> {
  const slider = document.querySelector<HTMLInputElement>(".isovalue-slider");
  if (!slider) throw new Error("no slider");
  const [low, high] = [Number(slider.min), Number(slider.max)];
  const begin = performance.now();
  const past = () => (performance.now() - begin) / 1000;
  for (let t = 0; t < 1; t = past() / seconds) {
    slider.valueAsNumber = low + t * (high - low);
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    await new Promise((resolve) => requestAnimationFrame(resolve));
  }
  return past();
}

/** The GL renderer: the tests' pictures are comparable only on llvmpipe. */
export function rendererName(): string {
  const gl = document.createElement("canvas").getContext("webgl2");
  const info = gl?.getExtension("WEBGL_debug_renderer_info");
  return String(gl?.getParameter(info?.UNMASKED_RENDERER_WEBGL ?? 0));
}

/** Turns the browser's data saver on, so that nothing is fetched ahead. */
export function saveData(): void {
  Object.defineProperty(navigator, "connection", { value: { saveData: true } });
}
