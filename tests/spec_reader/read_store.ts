// A reader of the store's directory, written from shared/core/store/FORMAT.md alone. It shares no code with
// the rest, so it tests whether the specification is complete. read_chunk.ts decodes chunks.

export interface Chunk {
  level: number;
  block: [number, number, number];
  band: number;
  begin: number;
  end: number;
  offset: number;
  bytes: number;
  cells: number;
}

/** A field of a store. Its chunks have the addresses of the store's, and offsets in the file. */
export interface Field {
  name: string;
  bits: number;
  hasMissing: boolean;
  missingVoxels: number;
  offset: number;
  scale: number;
  maxError: number;
  range: [number, number];
  levels: Store["levels"];
}

export interface Store {
  version: [number, number];
  fileBytes: number;
  voxels: [number, number, number];
  bits: number;
  hasMissing: boolean;
  spacing: number[];
  offset: number;
  scale: number;
  range: [number, number];
  metadata: Record<string, unknown>;
  /** For each level: the cells along each axis, and the chunks that have cells, page by page. */
  levels: { cells: number[]; chunks: Chunk[] }[];
  fields: Field[];
  /** Of a field: where the payload of its section FIEL begins. */
  ownField: number;
}

function check(condition: boolean, what: string): asserts condition {
  if (!condition) throw new Error(what);
}

export function readStore(file: Uint8Array, isField = false): Store {
  const view = new DataView(file.buffer, file.byteOffset, file.byteLength);
  const u16 = (at: number) => view.getUint16(at, true);
  const u24 = (at: number) => u16(at) + view.getUint8(at + 2) * 65536;
  const u32 = (at: number) => view.getUint32(at, true);
  const u48 = (at: number) => u32(at) + u16(at + 4) * 2 ** 32;
  const u64 = (at: number) => Number(view.getBigUint64(at, true));
  const f64 = (at: number) => view.getFloat64(at, true);

  // The header.
  const magic = [0x89, 0x49, 0x53, 0x4f, 0x53, 0x0d, 0x0a, 0x1a];
  check(
    magic.every((byte, i) => file[i] === byte),
    "magic",
  );
  const version: [number, number] = [u16(8), u16(10)];
  check(version[0] === 1, "major version");
  const headerBytes = u32(12);
  const fileBytes = u64(16);
  check(
    headerBytes % 8 === 0 && headerBytes <= 65536 && headerBytes <= file.length,
    "header_bytes",
  );
  check(fileBytes === file.length, "file_bytes");
  const sections = new Map<string, number>();
  let at = 48;
  for (let i = 0; i < u32(24); ++i) {
    check(at + 8 <= headerBytes - 8, "section");
    const tag = String.fromCharCode(...file.subarray(at, at + 4));
    check(!sections.has(tag), "a section twice");
    sections.set(tag, at + 8);
    at += 8 + Math.ceil(u32(at + 4) / 8) * 8;
  }
  const section = (tag: string) => {
    const found = sections.get(tag);
    check(found !== undefined, `no section ${tag}`);
    return found;
  };

  // Volume and metadata.
  const volume = section("VOLU");
  const voxels: [number, number, number] = [u32(volume), u32(volume + 4), u32(volume + 8)];
  const meta = section("META");
  const text = new TextDecoder().decode(file.subarray(meta, meta + u32(meta - 4)));

  // Fields.
  check(sections.has("FIEL") === isField, "a field outside of its store");
  const fields: Field[] = [];
  let fieldsEnd = headerBytes;
  const list = sections.get("flds");
  if (list !== undefined) {
    check(!isField, "fields of a field");
    let record = list + 8;
    for (let i = 0; i < u32(list); ++i) {
      const bytes = u64(record);
      const nameBytes = view.getUint8(record + 46);
      const recordBytes = Math.ceil((40 + nameBytes) / 8) * 8;
      const within = file.subarray(fieldsEnd, fieldsEnd + bytes);
      const field = readStore(within, true);
      const own = within.subarray(field.ownField, field.ownField + recordBytes);
      const listed = file.subarray(record + 8, record + 8 + recordBytes);
      check(
        listed.every((byte, at) => own[at] === byte),
        "FIEL differs from flds",
      );
      const moved = field.levels.map(({ cells, chunks }) => ({
        cells,
        chunks: chunks.map((chunk) => ({ ...chunk, offset: chunk.offset + fieldsEnd })),
      }));
      fields.push({
        name: String.fromCharCode(...file.subarray(record + 48, record + 48 + nameBytes)),
        offset: f64(record + 8),
        scale: f64(record + 16),
        maxError: f64(record + 24),
        missingVoxels: u64(record + 32),
        range: [u16(record + 40), u16(record + 42)],
        bits: view.getUint8(record + 44),
        hasMissing: (view.getUint8(record + 45) & 1) === 1,
        levels: moved,
      });
      fieldsEnd += bytes;
      record += 8 + recordBytes;
    }
    check(record === list + u32(list - 4), "bytes of section flds");
  }

  // Levels.
  const levels: Store["levels"] = [];
  for (let cells = voxels.map((n) => n - 1); ; cells = cells.map((n) => Math.ceil(n / 2))) {
    levels.push({ cells, chunks: [] });
    if (Math.max(...cells) <= 16) break;
  }
  const levl = section("LEVL");
  check(u32(levl) === levels.length, "levels");
  const pageSide = 2 ** u32(levl + 4);
  let chunksEnd = headerBytes;
  levels.forEach((_, l) => {
    check(u64(levl + 8 + 32 * l) === chunksEnd, "chunks_offset");
    chunksEnd += u64(levl + 16 + 32 * l);
  });

  // Pages, coarsest level first.
  let record = section("PAGE");
  let page = chunksEnd;
  for (let l = levels.length - 1; l >= 0; --l) {
    const level = levels[l] as Store["levels"][number];
    const blocks = level.cells.map((n) => Math.ceil(n / 64));
    const [bx, by, bz] = blocks as [number, number, number];
    let pageCount = 0;
    for (let z = 0; z < bz; z += pageSide) {
      for (let y = 0; y < by; y += pageSide) {
        for (let x = 0; x < bx; x += pageSide) {
          readPage(level.chunks, l, [x, y, z], [bx, by, bz]);
          page += u32(record);
          record += 12;
          ++pageCount;
        }
      }
    }
    check(u32(levl + 8 + 32 * l + 28) === pageCount, "page_count");
    check(u64(levl + 8 + 32 * l + 16) === level.chunks.length, "chunk_count");
  }
  check(page === fileBytes, "the pages end with the file");

  function readPage(
    chunks: Chunk[],
    level: number,
    first: [number, number, number],
    blocks: [number, number, number],
  ) {
    const end = first.map((n, axis) => Math.min(n + pageSide, blocks[axis] as number));
    const [ex, ey, ez] = end as [number, number, number];
    let block = page + 8;
    let band = block + 12 * u32(page);
    check(band + 12 * u32(page + 4) === page + u32(record), "bytes of a page");
    for (let z = first[2]; z < ez; ++z) {
      for (let y = first[1]; y < ey; ++y) {
        for (let x = first[0]; x < ex; ++x, block += 12) {
          let offset = u48(block);
          let begin = u16(block + 6);
          for (let s = 0; s < u16(block + 10); ++s, band += 12) {
            const [bytes, cells, bandEnd] = [u24(band + 4), u24(band + 7), u16(band + 10)];
            check(bandEnd > begin, "bands ascend");
            const chunk = { level, band: s, begin, end: bandEnd, offset, bytes, cells };
            if (cells > 0) chunks.push({ ...chunk, block: [x, y, z] });
            offset += bytes;
            begin = bandEnd;
          }
          check(begin === u16(block + 8), "bands tile the block's interval");
        }
      }
    }
  }

  return {
    version,
    fileBytes,
    voxels,
    bits: view.getUint8(volume + 12),
    hasMissing: (view.getUint8(volume + 13) & 1) === 1,
    spacing: [16, 24, 32].map((byte) => f64(volume + byte)),
    offset: f64(volume + 136),
    scale: f64(volume + 144),
    range: [u16(volume + 168), u16(volume + 170)],
    metadata: JSON.parse(text),
    levels,
    fields,
    ownField: sections.get("FIEL") ?? 0,
  };
}
