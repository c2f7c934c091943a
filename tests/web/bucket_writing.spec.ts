/** Stores that are written to buckets: an S3 service that verifies signatures, with faults between. */
import {
  existsSync,
  mkdirSync,
  mkdtempSync,
  readdirSync,
  readFileSync,
  rmSync,
  writeFileSync,
} from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { afterAll, afterEach, beforeAll, beforeEach, describe, expect, test } from "vitest";
import { program } from "../browser/support/server.ts";
import { type Fault, FaultProxy } from "../support/fault_proxy.ts";
import { type Ran, runProgram } from "../support/run_program.ts";
import { account, S3Service } from "../support/s3_service.ts";
import { nobody, person } from "../support/s3_settings.ts";

const bucket = "volumes";
const mebibyte = 1 << 20;

/** Noise, whose store is about as large as the volume. */
function noise(bytes: number): Buffer {
  const volume = Buffer.alloc(bytes);
  let state = 1;
  for (let i = 0; i < bytes; ++i) {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    volume[i] = state >>> 24;
  }
  return volume;
}

/** The only line of stderr apart from progress and notes, which has no credentials. */
function errorOf(ran: Ran, code = 1): string {
  expect(ran.code, ran.stderr).toBe(code);
  expect(ran.stderr + ran.stdout).not.toContain(account.secretKey);
  return ran.stderr.trimEnd().split("\n").at(-1) ?? "";
}

describe.skipIf(!existsSync(program))("a build to a bucket", () => {
  const folder = mkdtempSync(join(tmpdir(), "isosplat-writing-"));
  const small = join(folder, "small.raw");
  const large = join(folder, "large.raw");
  let service: S3Service;
  let proxy: FaultProxy;
  let whole: { small: Buffer; large: Buffer };

  /** Draws thumbnails: vitest.config.ts leaves them out. */
  const pictured = { ISOSPLAT_NO_THUMBNAIL: "0" };
  const shape = (volume: string): string[] =>
    volume === small ? ["--dims", "40x30x20"] : ["--dims", "280x280x240"];
  const build = (
    volume: string,
    key: string,
    options: readonly string[] = [],
    env: Record<string, string | undefined> = person,
  ) => {
    const to = ["-o", `s3://${bucket}/${key}`, "--endpoint", proxy.url, "--no-thumbnail"];
    const args = ["build", volume, ...shape(volume), "--type", "u8", ...to, ...options];
    return runProgram(args, { TMPDIR: folder, ...env });
  };
  /** The bytes that a build writes to the bucket without faults: a valid store. */
  async function built(volume: string): Promise<Buffer> {
    const args = ["build", volume, ...shape(volume), "--type", "u8", "--no-thumbnail"];
    const address = `s3://${bucket}/reference.isosplat`;
    const to = ["-o", address, "--endpoint", service.url, "--force"];
    const ran = await runProgram([...args, ...to], { ...person, TMPDIR: folder });
    expect(ran.code, ran.stderr).toBe(0);
    const verified = await runProgram(["verify", address, "--endpoint", service.url], person);
    expect(verified.code, verified.stderr).toBe(0);
    return (await service.get(`${bucket}/reference.isosplat`))?.bytes ?? Buffer.alloc(0);
  }
  const object = (key: string) => service.get(`${bucket}/${key}`);
  const folders = (kind: "upload" | "kept") =>
    readdirSync(folder).filter((name) => name.startsWith(`isosplat-${kind}-`));
  /** The file that the program kept after this error. Removes it. */
  function kept(error: string, key: string): Buffer {
    const [, path = "", address = ""] = /kept: aws s3 cp '(.*)' '(.*?)'/.exec(error) ?? [];
    expect(address).toBe(`s3://${bucket}/${key}`);
    const bytes = readFileSync(path);
    rmSync(dirname(path), { recursive: true });
    return bytes;
  }

  beforeAll(async () => {
    writeFileSync(small, noise(40 * 30 * 20));
    writeFileSync(large, noise(280 * 280 * 240));
    service = new S3Service(join(folder, "s3"), bucket);
    await service.start();
    whole = { small: await built(small), large: await built(large) };
    expect(whole.large.length).toBeGreaterThan(16 * mebibyte);
  }, 120_000);
  beforeEach(async () => {
    service.account = account;
    service.clockAhead = 0;
    service.refused.length = 0;
    proxy = new FaultProxy(service.url);
    proxy.keepsHost = true;
    await proxy.start();
  });
  afterEach(async () => {
    expect(folders("upload")).toEqual([]);
    for (const name of folders("kept")) rmSync(join(folder, name), { recursive: true });
    await proxy.stop();
  });
  afterAll(async () => {
    await service?.stop();
    rmSync(folder, { recursive: true, force: true });
  });

  test("writes a small store in one request", async () => {
    const ran = await build(small, "a/small.isosplat");
    expect(ran.code, ran.stderr).toBe(0);
    expect(ran.stdout).toContain(`s3://${bucket}/a/small.isosplat: `);
    expect((await object("a/small.isosplat"))?.bytes.equals(whole.small)).toBe(true);
    const methods = proxy.requests.map(({ method }) => method);
    expect(methods).toEqual(["HEAD", "PUT", "HEAD"]);
    expect(service.refused).toEqual([]);
  });

  test("writes a large store in parts", async () => {
    const ran = await build(large, "large.isosplat");
    expect(ran.code, ran.stderr).toBe(0);
    expect((await object("large.isosplat"))?.bytes.equals(whole.large)).toBe(true);
    const parts = proxy.requests.filter(
      ({ method, path }) => method === "PUT" && /partNumber/.test(path),
    );
    expect(parts).toHaveLength(Math.ceil(whole.large.length / (16 * mebibyte)));
    expect(service.refused).toEqual([]);
  });

  test("writes the thumbnail beside the store, and it can be read", async () => {
    const address = `s3://${bucket}/with picture.isosplat`;
    const args = ["build", small, ...shape(small), "--type", "u8", "-o", address];
    const ran = await runProgram([...args, "--endpoint", proxy.url], {
      ...person,
      TMPDIR: folder,
      ...pictured,
    });
    expect(ran.code, ran.stderr).toBe(0);
    expect((await object("with%20picture.isosplat.webp"))?.headers.get("content-type")).toBe(
      "image/webp",
    );
    const verified = await runProgram(["verify", address, "--endpoint", proxy.url], person);
    expect(verified.code, verified.stderr).toBe(0);
  });

  test.each<[string, Fault]>([
    ["resets", { kind: "reset" }],
    ["status 500", { kind: "status", status: 500 }],
    [
      "requests to slow down",
      { kind: "status", status: 503, body: "<Error><Code>SlowDown</Code></Error>" },
    ],
    ["changed bodies", { kind: "corrupt-request" }],
    ["lost responses", { kind: "truncate", bytes: 0 }],
  ])("writes the right object in spite of %s", async (_, fault) => {
    const failed = new Set<string>();
    proxy.fault = (path, _number, method) => {
      const request = `${method} ${path}`;
      // A lost response without a body is complete.
      if (failed.has(request) || (fault.kind === "truncate" && method !== "POST")) return undefined;
      failed.add(request);
      return fault;
    };
    const ran = await build(large, "large.isosplat", ["--force"]);
    expect(ran.code, ran.stderr).toBe(0);
    expect((await object("large.isosplat"))?.bytes.equals(whole.large)).toBe(true);
    expect(failed.size).toBeGreaterThan(1);
  });

  test.each([
    ["ExpiredToken", "get new ones"],
    ["RequestTimeTooSkewed", "set this machine's clock"],
    ["AccessDenied", "your credentials"],
  ])("that is refused in the middle (%s) is aborted, with one error", async (code, remedy) => {
    proxy.fault = (path) =>
      /partNumber=2/.test(path)
        ? { kind: "status", status: 403, body: `<Error><Code>${code}</Code></Error>` }
        : undefined;
    const error = errorOf(await build(large, "refused.isosplat"));
    expect(error).toContain("sending part 2 of");
    expect(error).toContain(code);
    expect(error).toContain(remedy);
    expect(proxy.requests.at(-1)?.method).toBe("DELETE");
    expect(proxy.requests.at(-1)?.path).toContain("uploadId=");
    expect(await object("refused.isosplat")).toBeUndefined();
    expect(kept(error, "refused.isosplat").equals(whole.large)).toBe(true);
    expect(error).toContain(`--endpoint-url '${proxy.url}' uploads it`);
  });

  test("that ends in a longer fault of the network writes the object", async () => {
    let resets = 0;
    proxy.fault = (path) =>
      /partNumber=1&/.test(path) && ++resets < 7 ? { kind: "reset" } : undefined;
    const ran = await build(large, "patient.isosplat");
    expect(ran.code, ran.stderr).toBe(0);
    expect(resets).toBe(7);
  }, 60_000);

  test("reads the credentials again before it sends", async () => {
    const credentials = join(folder, "credentials");
    const write = (token: string) =>
      writeFileSync(
        credentials,
        `[default]\naws_access_key_id=${account.accessKey}\n` +
          `aws_secret_access_key=${account.secretKey}\naws_session_token=${token}\n`,
      );
    write("old");
    proxy.fault = (_path, number) => {
      if (number > 1) return undefined;
      write("new");
      service.account = { ...account, sessionToken: "new" };
      return { kind: "status", status: 404 };
    };
    const env = {
      ...nobody,
      AWS_REGION: account.region,
      AWS_SHARED_CREDENTIALS_FILE: credentials,
    };
    const ran = await build(small, "renewed.isosplat", [], env);
    expect(ran.code, ran.stderr).toBe(0);
    expect(service.refused).toEqual([]);
  });

  test("removes what a killed build has left, and nothing that is in use or kept", async () => {
    const left = join(folder, "isosplat-upload-abcdef");
    const other = join(folder, "isosplat-kept-abcdef");
    for (const path of [left, other]) mkdirSync(path);
    writeFileSync(join(left, "a.isosplat"), "unfinished");
    const used = () => folders("upload").filter((name) => name !== "isosplat-upload-abcdef");
    let inUse: string[] = [];
    proxy.fault = (_path, number) => {
      if (number > 1) return undefined;
      inUse = used();
      return { kind: "delay", milliseconds: 1000 };
    };
    const first = build(small, "first.isosplat");
    await expect.poll(() => inUse.length).toBe(1);
    expect(existsSync(left)).toBe(false);
    expect((await build(small, "second.isosplat")).code).toBe(0);
    expect((await first).code).toBe(0);
    expect(existsSync(other)).toBe(true);
  });

  test("that is completed slowly is complete, with one request", async () => {
    const completes = () =>
      proxy.requests.filter(({ method, path }) => method === "POST" && /uploadId/.test(path));
    proxy.fault = (path, _number, method) =>
      method === "POST" && /uploadId/.test(path)
        ? { kind: "delay", milliseconds: 3000 }
        : undefined;
    const ran = await build(large, "slow.isosplat", ["--timeout", "1"]);
    expect(ran.code, ran.stderr).toBe(0);
    expect(completes()).toHaveLength(1);
  });

  test("that is complete although no response says so is recognized", async () => {
    proxy.fault = (path, _number, method) =>
      method === "POST" && /uploadId/.test(path) ? { kind: "truncate", bytes: 0 } : undefined;
    const ran = await build(large, "unheard.isosplat");
    expect(ran.code, ran.stderr).toBe(0);
    expect((await object("unheard.isosplat"))?.bytes.equals(whole.large)).toBe(true);
    expect(proxy.requests.some(({ method }) => method === "DELETE")).toBe(false);
  });

  test.each([
    [404, false],
    [403, true],
  ])("whose abortion is answered by %s: parts remain: %s", async (status, remain) => {
    proxy.fault = (path, _number, method) => {
      if (method === "DELETE") return { kind: "status", status };
      return /partNumber=2/.test(path) ? { kind: "status", status: 403 } : undefined;
    };
    const error = errorOf(await build(large, "aborted.isosplat"));
    expect(error.includes("remain in the bucket")).toBe(remain);
  });

  test("to a service whose clock differs is one error before the build", async () => {
    service.clockAhead = 3_600_000;
    const error = errorOf(await build(small, "never.isosplat"));
    expect(error).toContain("status 403 (RequestTimeTooSkewed");
    expect(error).toContain("set this machine's clock");
    expect(await object("never.isosplat")).toBeUndefined();
  });

  test("in another region is one error before the build, which names the region", async () => {
    proxy.fault = () => ({
      kind: "status",
      status: 400,
      headers: { "x-amz-bucket-region": "eu-x" },
    });
    const error = errorOf(await build(small, "never.isosplat"));
    expect(error).toContain("set AWS_REGION to eu-x");
  });

  test("that fails at its end, after status 200, is one error", async () => {
    proxy.fault = (path, _number, method) =>
      method === "POST" && /uploadId/.test(path)
        ? { kind: "status", status: 200, body: "<Error><Code>InternalError</Code></Error>" }
        : undefined;
    const error = errorOf(await build(large, "half.isosplat"));
    expect(error).toContain("completing the upload");
    expect(error).toContain("InternalError");
    expect(kept(error, "half.isosplat").equals(whole.large)).toBe(true);
    expect(await object("half.isosplat")).toBeUndefined();
  });

  test.each(["a\r\nb", "a b", "", "x".repeat(5000)])(
    "to a service that gives the upload a malformed id is one error",
    async (id) => {
      const body = `<UploadId>${id}</UploadId>`;
      proxy.fault = (path) =>
        /\?uploads/.test(path) ? { kind: "status", status: 200, body } : undefined;
      expect(errorOf(await build(large, "id.isosplat"))).toContain("expected the id of an upload");
    },
  );

  test("needs only the right to write, with --force", async () => {
    proxy.fault = (_path, _number, method) =>
      method === "HEAD" || method === "GET" ? { kind: "status", status: 403 } : undefined;
    expect((await build(small, "blind.isosplat", ["--force"])).code).toBe(0);
    expect((await object("blind.isosplat"))?.bytes.equals(whole.small)).toBe(true);
    expect(errorOf(await build(small, "blind.isosplat"))).toContain("status 403");
  });

  test("without credentials is one error before the build", async () => {
    const error = errorOf(await build(small, "never.isosplat", [], nobody), 2);
    expect(error).toContain("expected credentials for writing");
    expect(proxy.requests).toHaveLength(0);
  });

  test("replaces a store of the same volume, and nothing else", async () => {
    expect((await build(small, "same.isosplat")).code).toBe(0);
    expect((await build(small, "same.isosplat")).code).toBe(0);
    expect(errorOf(await build(large, "same.isosplat"), 2)).toContain("a store of another volume");
    await service.put(`${bucket}/note.txt`, Buffer.from("a note"));
    expect(errorOf(await build(small, "note.txt"), 2)).toContain("found another object");
    expect((await build(small, "note.txt", ["--force"])).code).toBe(0);
  });

  test("knows a volume by its path, wherever the temporary folder is", async () => {
    const at = async (name: string) => {
      mkdirSync(join(folder, name, "temporary/deep"), { recursive: true });
      const volume = join(folder, name, "a.raw");
      writeFileSync(volume, readFileSync(small));
      const to = (temporary: string) => {
        const env = { ...person, TMPDIR: join(folder, name, temporary) };
        const args = ["build", volume, ...shape(small), "--type", "u8", "--no-thumbnail"];
        return runProgram([...args, "-o", `s3://${bucket}/p`, "--endpoint", proxy.url], env);
      };
      return { shallow: await to("temporary"), deep: await to("temporary/deep") };
    };
    const one = await at("one");
    expect([one.shallow.code, one.deep.code]).toEqual([0, 0]);
    const two = await at("two");
    expect(errorOf(two.shallow, 2)).toContain("a store of another volume");
  });

  test("replaces no object but a thumbnail by the thumbnail, without --force", async () => {
    await service.put(`${bucket}/pictured.isosplat.webp`, Buffer.from("a photograph of a cat"));
    const to = ["-o", `s3://${bucket}/pictured.isosplat`, "--endpoint", proxy.url];
    const args = ["build", small, ...shape(small), "--type", "u8", ...to];
    const picture = async () => (await object("pictured.isosplat.webp"))?.bytes.subarray(8, 12);
    const ran = await runProgram(args, { ...person, ...pictured, TMPDIR: folder });
    expect(ran.code, ran.stderr).toBe(0);
    expect(ran.stderr).toContain("expected no object, or a thumbnail, found another object");
    expect(String(await picture())).not.toBe("WEBP");
    for (const options of [["--force"], []]) {
      const again = await runProgram([...args, ...options], {
        ...person,
        ...pictured,
        TMPDIR: folder,
      });
      expect(again.stderr).not.toContain("no thumbnail");
      expect(String(await picture())).toBe("WEBP");
    }
  });

  test.each([
    ["--resume", ["--resume"]],
    ["--part", ["--part", "1/2"]],
  ])("cannot be continued: %s is one error", async (name, options) => {
    expect(errorOf(await build(small, "a.isosplat", options), 2)).toContain(`${name}: expected`);
  });

  test("to a web address is one error", async () => {
    const args = ["build", small, ...shape(small), "--type", "u8", "-o", "https://a.example/b"];
    expect(errorOf(await runProgram(args), 2)).toContain("s3://BUCKET/KEY");
  });
});
