import { describe, expect, it } from "vitest";
import { covering, partIn } from "../../web/offline/byte_ranges.ts";
import { chunkAddresses, chunksInFrames, framesOf } from "../../web/offline/chunk_frames.ts";
import { answerKind } from "../../web/offline/seen_answers.ts";
import { FrameReader } from "../../web/stream/frames.ts";

const id = "0123456789abcdef0123456789abcdef";

describe("the responses that are kept", () => {
  it.each([
    ["v1/volumes", "", "list"],
    ["v1/volumes", "?query=head", undefined],
    ["catalog.json", "", "list"],
    ["v1/volumes/head", "", "list"],
    ["v1/volumes/head/bootstrap", "", "list"],
    [`v1/volumes/head/${id}/batch`, "?chunks=0/0.0.0/1", { store: id }],
    [`v1/volumes/${id}/bootstrap`, "", "list"],
    [`stores/head-${id}.isosplat`, "", { store: id }],
    [`head-${id}-0123abcd.webp`, "", { store: id }],
    ["v1/scenes", "", "list"],
    ["v1/scenes/run", "", "list"],
    ["v1/scenes/run~scene/bootstrap", "", "list"],
    ["v1/scenes/run/0123456789abcdef/file", "", { store: "0123456789abcdef" }],
    ["stores/run-0123456789abcdef.isobundle", "", { store: "0123456789abcdef" }],
    ["stores/run-0123456789abcdef-0123abcd.webp", "", { store: "0123456789abcdef" }],
    ["metrics", "", undefined],
    ["head.isosplat", "", undefined],
  ])("%s%s", (path, query, kind) => expect(answerKind(path, query)).toEqual(kind));
});

describe("parts of a file", () => {
  it("are read from headers", () => {
    expect(partIn("bytes=5-9")).toEqual({ first: 5, last: 9 });
    expect(partIn("bytes 5-9/100")).toEqual({ first: 5, last: 9 });
    for (const other of [null, "", "bytes=-5", "bytes=5-", "bytes=1-2,5-6", "bytes */5"]) {
      expect(partIn(other)).toBeUndefined();
    }
  });

  it("cover another range if they leave no gap", () => {
    const kept = [
      { first: 0, last: 9 },
      { first: 5, last: 6 },
      { first: 8, last: 30 },
      { first: 40, last: 50 },
    ];
    expect(covering({ first: 3, last: 20 }, kept)).toEqual([kept[0], kept[2]]);
    expect(covering({ first: 41, last: 42 }, kept)).toEqual([kept[3]]);
    expect(covering({ first: 20, last: 45 }, kept)).toBeUndefined();
    expect(covering({ first: 0, last: 0 }, [])).toBeUndefined();
  });
});

describe("the chunks of a batch", () => {
  const base = `https://a.example/v1/volumes/head/${id}/`;
  const places = ["0/1.2.3/4", "2/0.0.0/0", "1/7.0.1/12"];
  const addresses = places.map((place) => `${base}chunks/${place}`);
  const chunks = [20, 0, 16].map((bytes, i) => new Uint8Array(bytes).fill(i + 1));

  it("have the addresses of chunks that are requested alone", () => {
    expect(chunkAddresses(`${base}batch?chunks=${places.join(",")}`)).toEqual(addresses);
    expect(chunkAddresses(`${base}chunks/${places[0]}`)).toBeUndefined();
  });

  it("are combined to other batches, which the page reads", () => {
    const frames = framesOf(addresses, chunks);
    expect(chunksInFrames(frames)).toEqual(chunks);
    const asked = places.map((place, handle) => {
      const [level = 0, block = "", band = 0] = place.split("/");
      const at = { level: Number(level), band: Number(band), block: block.split(".").map(Number) };
      return { ...at, block: at.block as [number, number, number], handle, offset: 0 };
    });
    const read: Uint8Array[] = [];
    const reader = new FrameReader(
      asked.map((chunk, i) => ({ ...chunk, bytes: chunks[i]?.length ?? 0 })),
      (_, bytes) => read.push(bytes),
    );
    reader.add(frames);
    reader.end();
    expect(read).toEqual(chunks);
  });

  it("are kept only if they arrived completely and the server could read them", () => {
    const frames = framesOf(addresses, chunks);
    expect(chunksInFrames(frames.subarray(0, frames.length - 1))).toHaveLength(2);
    new DataView(frames.buffer).setUint32(4, 7, true); // the status of the first
    expect(chunksInFrames(frames)).toEqual([]);
  });
});
