// Blocks of LZ4 and of BloscLZ consist of runs of literal bytes, and of matches, which repeat earlier
// bytes.

const damaged = "the compressed bytes are damaged";

/** Bytes that are written in order; each run is checked against the input and the output. */
class Output {
  readonly bytes: Uint8Array;
  at = 0;

  constructor(size: number) {
    this.bytes = new Uint8Array(size);
  }

  literals(input: Uint8Array, from: number, count: number): void {
    if (from + count > input.length || this.at + count > this.bytes.length)
      throw new Error(damaged);
    this.bytes.set(input.subarray(from, from + count), this.at);
    this.at += count;
  }

  /** A match may overlap its own output, which it then repeats. */
  match(distance: number, count: number): void {
    const end = this.at + count;
    if (distance < 1 || distance > this.at || end > this.bytes.length) throw new Error(damaged);
    if (distance >= count) {
      this.bytes.copyWithin(this.at, this.at - distance, end - distance);
      this.at = end;
    } else {
      for (; this.at < end; ++this.at) {
        this.bytes[this.at] = this.bytes[this.at - distance] as number;
      }
    }
  }

  whole(): Uint8Array {
    if (this.at !== this.bytes.length) throw new Error(damaged);
    return this.bytes;
  }
}

/** Decodes a block of LZ4 of a known size (LZ4 block format). Throws if it is damaged. */
export function decodeLz4(input: Uint8Array, size: number): Uint8Array {
  const output = new Output(size);
  let at = 0;
  const next = () => input[at++] ?? fail();
  const longer = (length: number) => {
    if (length < 15) return length;
    let sum = length;
    for (let more = 255; more === 255; sum += more) more = next();
    return sum;
  };
  while (at < input.length) {
    const token = next();
    const literals = longer(token >> 4);
    output.literals(input, at, literals);
    at += literals;
    if (at >= input.length) break; // the last run has no match
    const distance = next() | (next() << 8);
    output.match(distance, longer(token & 15) + 4);
  }
  return output.whole();
}

/** Matches with distances beyond this have two more bytes. */
const shortDistance = 8191;

/** Decodes a block of BloscLZ of a known size. Throws if it is damaged. */
export function decodeBloscLz(input: Uint8Array, size: number): Uint8Array {
  const output = new Output(size);
  let at = 0;
  const next = () => input[at++] ?? fail();
  for (let control = next() & 31; ; control = next()) {
    if (control < 32) {
      output.literals(input, at, control + 1);
      at += control + 1;
    } else {
      let length = (control >> 5) - 1;
      if (length === 6) {
        for (let more = 255; more === 255; length += more) more = next();
      }
      const high = (control & 31) << 8;
      const low = next();
      const isFar = low === 255 && high === 31 << 8;
      const distance = isFar ? ((next() << 8) | next()) + shortDistance : high + low;
      output.match(distance + 1, length + 3);
    }
    if (at >= input.length) return output.whole();
  }
}

function fail(): never {
  throw new Error(damaged);
}
