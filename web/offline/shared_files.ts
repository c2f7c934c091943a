/** Passes files that another app shares with this one from the service worker to the page. */
const cacheName = "isosplat-shared";
const nameHeader = "X-Isosplat-Name";

/** Keeps the files of the form that the system posts (`share_target` of the manifest). */
export async function keepSharedFiles(request: Request): Promise<void> {
  const files = (await request.formData()).getAll("files");
  await caches.delete(cacheName); // what nobody has taken
  const cache = await caches.open(cacheName);
  for (const [i, file] of files.entries()) {
    if (!(file instanceof File)) continue;
    const headers = { [nameHeader]: encodeURIComponent(file.name) };
    await cache.put(`shared-${i}`, new Response(file, { headers }));
  }
}

/** Takes the shared files, in their order. Each file is returned only once. */
export async function takeSharedFiles(): Promise<File[]> {
  if (!("caches" in globalThis) || !(await caches.has(cacheName))) return [];
  const cache = await caches.open(cacheName);
  const answers = await cache.matchAll();
  const files = answers.map(async (answer) => {
    const name = decodeURIComponent(answer.headers.get(nameHeader) ?? "shared");
    return new File([await answer.blob()], name);
  });
  const taken = await Promise.all(files);
  await caches.delete(cacheName);
  return taken;
}
