/** A Zstandard frame: its byte range in the file, and the checksum of its content, if it has one. */
export interface ZstdFrame {
  begin: number;
  end: number;
  checksum: number | undefined;
}

const magic = 0xfd2fb528;
/** The first of the 16 magic numbers of skippable frames. */
const skippable = 0x184d2a50;
const largestHeader = 18;

/**
 * The frames of a file (RFC 8878, 3.1). Throws at bytes that are not a frame, and if the file ends
 * within a frame.
 */
export async function* zstdFrames(file: Blob): AsyncGenerator<ZstdFrame> {
  const viewOf = async (begin: number, size: number) =>
    new DataView(await file.slice(begin, begin + size).arrayBuffer());
  for (let begin = 0; begin < file.size; ) {
    const head = await viewOf(begin, largestHeader);
    if (head.byteLength < 8) throw new Error("the data end early");
    const kind = head.getUint32(0, true);
    if (kind - (kind % 16) === skippable) {
      begin += 8 + head.getUint32(4, true);
      continue;
    }
    if (kind !== magic) throw new Error("what follows a frame is not a frame");
    const flags = head.getUint8(4);
    const isSingle = (flags & 32) !== 0;
    const sizeBytes = [isSingle ? 1 : 0, 2, 4, 8][flags >> 6] as number;
    const dictionaryBytes = [0, 1, 2, 4][flags & 3] as number;
    let at = begin + 5 + (isSingle ? 0 : 1) + dictionaryBytes + sizeBytes;
    for (let isLast = false; !isLast; ) {
      const block = await viewOf(at, 3);
      if (block.byteLength < 3) throw new Error("the data end early");
      const first = block.getUint8(0);
      const size = (first >> 3) + block.getUint16(1, true) * 32;
      isLast = (first & 1) !== 0;
      at += 3 + (((first >> 1) & 3) === 1 ? 1 : size); // a run has one byte
    }
    const hasChecksum = (flags & 4) !== 0;
    const end = at + (hasChecksum ? 4 : 0);
    if (end > file.size) throw new Error("the data end early");
    const checksum = hasChecksum ? (await viewOf(at, 4)).getUint32(0, true) : undefined;
    yield { begin, end, checksum };
    begin = end;
  }
}
