/**
 * Pictures of volumes for their cards. They are kept in local storage; the oldest are deleted
 * first. Without storage, cards show the histogram.
 */
const prefix = "isosplat-picture-";
const orderKey = "isosplat-pictures";
const maxPictures = 40;
export const pictureSize = { width: 360, height: 225 };

export function thumbnail(contentId: string): string | null {
  try {
    return localStorage.getItem(prefix + contentId);
  } catch {
    return null;
  }
}

/** Creates the picture: a WebP of a few KB, from the centre of the view. */
export async function keepThumbnail(contentId: string, picture: Blob): Promise<void> {
  const { width, height } = pictureSize;
  const bitmap = await createImageBitmap(picture);
  const canvas = document.createElement("canvas");
  canvas.width = width;
  canvas.height = height;
  const scale = Math.max(width / bitmap.width, height / bitmap.height);
  const w = bitmap.width * scale;
  const h = bitmap.height * scale;
  // Keep the canvas off the GPU: reading it back would wait for the pictures that are being drawn
  // there.
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context?.drawImage(bitmap, (width - w) / 2, (height - h) / 2, w, h);
  bitmap.close();
  const data = canvas.toDataURL("image/webp", 0.8);
  try {
    const order = (localStorage.getItem(orderKey) ?? "").split(" ").filter(Boolean);
    const next = [contentId, ...order.filter((id) => id !== contentId)];
    for (const old of next.splice(maxPictures)) localStorage.removeItem(prefix + old);
    localStorage.setItem(prefix + contentId, data);
    localStorage.setItem(orderKey, next.join(" "));
  } catch {
    // The storage is full or disabled: the card shows the histogram.
  }
}

/** Creates and stores the picture when the browser is idle. */
export function keepThumbnailWhenIdle(contentId: string, picture: () => Promise<Blob>): void {
  const keep = () =>
    picture()
      .then((blob) => keepThumbnail(contentId, blob))
      .catch(() => {}); // the card shows the histogram instead
  // Safari has no idle callback.
  if ("requestIdleCallback" in window) requestIdleCallback(keep, { timeout: 5000 });
  else setTimeout(keep, 1000);
}
