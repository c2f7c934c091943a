/** The chunks, `level/x.y.z/band`, that a list of addresses asks for. */
export function chunksOf(urls: readonly string[]): string[] {
  return urls.flatMap((address) => {
    const text = decodeURIComponent(address);
    const single = /\/chunks\/(\d+\/[\d.]+\/\d+)$/.exec(text)?.[1];
    return single ? [single] : (/batch\?chunks=(.*)$/.exec(text)?.[1]?.split(",") ?? []);
  });
}
