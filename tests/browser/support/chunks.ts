/** The chunks, `level/x.y.z/band`, in a list of request addresses. */
export function chunksOf(urls: readonly string[]): string[] {
  return urls.flatMap((address) => {
    const text = decodeURIComponent(address);
    const single = /\/chunks\/(\d+\/[\d.]+\/\d+)$/.exec(text)?.[1];
    return single ? [single] : (/batch\?chunks=(.*)$/.exec(text)?.[1]?.split(",") ?? []);
  });
}
