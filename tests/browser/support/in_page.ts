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

/** The GL renderer: the tests' pictures are comparable only on llvmpipe. */
export function rendererName(): string {
  const gl = document.createElement("canvas").getContext("webgl2");
  const info = gl?.getExtension("WEBGL_debug_renderer_info");
  return String(gl?.getParameter(info?.UNMASKED_RENDERER_WEBGL ?? 0));
}
