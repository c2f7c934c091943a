/**
 * Functions that tests run in the page, whichever program drives the browser. Each stands by itself:
 * only its text gets there.
 */

/** Loses the view's context; answers when the page has been told. */
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

/** Gives back the context that `loseContext` took. */
export function restoreContext(): void {
  (window as unknown as { loss: WEBGL_lose_context }).loss.restoreContext();
}

/** Moves the panel's isovalue slider, as a hand does. */
export function slideTo(isovalue: number): void {
  const slider = document.querySelector<HTMLElement & { value: number }>(
    "wa-slider.isovalue-slider",
  );
  if (!slider) throw new Error("no slider");
  slider.value = isovalue;
  slider.dispatchEvent(new Event("input", { bubbles: true }));
}

/** What GL draws with: the tests' pictures are only comparable on llvmpipe. */
export function rendererName(): string {
  const gl = document.createElement("canvas").getContext("webgl2");
  const info = gl?.getExtension("WEBGL_debug_renderer_info");
  return String(gl?.getParameter(info?.UNMASKED_RENDERER_WEBGL ?? 0));
}
