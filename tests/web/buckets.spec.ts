/** Stores in buckets: an S3 service that verifies signatures, with faults between. */
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import type { AddressInfo } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { afterAll, afterEach, beforeAll, beforeEach, describe, expect, test } from "vitest";
import { program } from "../browser/support/server.ts";
import { FaultProxy } from "../support/fault_proxy.ts";
import { type Ran, runProgram } from "../support/run_program.ts";
import { account, S3Service } from "../support/s3_service.ts";
import { nobody, person } from "../support/s3_settings.ts";
import { storeBytes } from "../support/store_bytes.ts";

/** The only line of stderr, which has no credentials. */
function errorOf(ran: Ran, code = 1): string {
  expect(ran.code, ran.stderr).toBe(code);
  expect(ran.stderr.trimEnd().split("\n")).toHaveLength(1);
  for (const secret of [account.secretKey, account.accessKey, "sesame"]) {
    expect(ran.stderr + ran.stdout).not.toContain(secret);
  }
  return ran.stderr;
}

describe.skipIf(!existsSync(program))("a store in a bucket", () => {
  const folder = mkdtempSync(join(tmpdir(), "isosplat-bucket-"));
  const bucket = "volumes";
  let service: S3Service;
  let proxy: FaultProxy;
  const run = (args: readonly string[], env: Record<string, string | undefined> = person) =>
    runProgram([...args, "--endpoint", proxy.url], env);

  beforeAll(async () => {
    service = new S3Service(join(folder, "s3"), bucket);
    await service.start();
    await service.put(`${bucket}/stores/head.isosplat`, storeBytes());
    await service.put(`${bucket}/a%20b%2Bc%3D%C3%A4%21%28x%29/d~_.isosplat`, storeBytes());
  });
  beforeEach(async () => {
    service.account = account;
    service.isPublic = false;
    service.clockAhead = 0;
    service.refused.length = 0;
    proxy = new FaultProxy(service.url);
    proxy.keepsHost = true;
    await proxy.start();
  });
  afterEach(() => proxy.stop());
  afterAll(async () => {
    await service?.stop();
    rmSync(folder, { recursive: true, force: true });
  });

  test("is verified, with requests signed by the environment's credentials", async () => {
    const ran = await run(["verify", `s3://${bucket}/stores/head.isosplat`]);
    expect(ran.code, ran.stderr).toBe(0);
    expect(ran.stdout).toContain(`s3://${bucket}/stores/head.isosplat: valid`);
    expect(service.refused).toEqual([]);
  });

  test.each([
    ["s3://volumes/a.isosplat", "volumes.s3.eu-test-1.amazonaws.com:443"],
    ["s3://my.volumes/a.isosplat", "s3.eu-test-1.amazonaws.com:443"],
  ])("of AWS is asked for at the host of its region: %s", async (address, host) => {
    const asked: string[] = [];
    const tunnel = createServer();
    tunnel.on("connect", ({ url }, socket) => {
      asked.push(url ?? "");
      socket.end("HTTP/1.1 403 Forbidden\r\n\r\n");
    });
    await new Promise<void>((listening) => tunnel.listen(0, "127.0.0.1", listening));
    const https_proxy = `http://127.0.0.1:${(tunnel.address() as AddressInfo).port}`;
    const env = { ...person, https_proxy, no_proxy: undefined, NO_PROXY: undefined };
    expect(errorOf(await runProgram(["info", address], env))).toContain(address);
    expect(asked).toEqual([host]); // a refusal of a proxy lasts
    tunnel.close();
  });

  test("may have a key with any characters", async () => {
    const ran = await run(["info", `s3://${bucket}/a b+c=ä!(x)/d~_.isosplat`, "--json"]);
    expect(ran.code, ran.stderr).toBe(0);
  });

  test("is read with temporary credentials, whose token is signed", async () => {
    service.account = { ...account, sessionToken: "FwoG/Zl+token==" };
    const address = `s3://${bucket}/stores/head.isosplat`;
    const env = { ...person, AWS_SESSION_TOKEN: "FwoG/Zl+token==" };
    expect((await run(["info", address], env)).code).toBe(0);
    expect(errorOf(await run(["info", address]))).toContain("InvalidAccessKeyId");
  });

  test("is read with a profile, and the endpoint of the environment", async () => {
    const credentials = join(folder, "credentials");
    const config = join(folder, "config");
    writeFileSync(
      credentials,
      `[default]\naws_access_key_id = other\naws_secret_access_key = other\n# comment\n\n[lab]\n` +
        `aws_access_key_id=${account.accessKey}\naws_secret_access_key = ${account.secretKey}\n`,
    );
    writeFileSync(
      config,
      `[profile lab]\nregion = ${account.region}\ns3 =\n  region = nowhere\nendpoint_url = ${proxy.url}\n` +
        `[profile sso]\nsso_session = lab\n[profile half]\naws_access_key_id = sesame\n`,
    );
    const env = { ...nobody, AWS_SHARED_CREDENTIALS_FILE: credentials, AWS_CONFIG_FILE: config };
    const info = (profile: string) =>
      runProgram(["info", `s3://${bucket}/stores/head.isosplat`], { ...env, AWS_PROFILE: profile });
    const read = await info("lab");
    expect(read.code, read.stderr).toBe(0);
    expect(errorOf(await info("none"), 2)).toContain("expected a profile");
    expect(errorOf(await info("sso"), 2)).toContain("aws configure export-credentials");
    expect(errorOf(await info("half"), 2)).toContain("no secret key");
  });

  test("of everyone is read without credentials", async () => {
    service.isPublic = true;
    const ran = await run(["info", `s3://${bucket}/stores/head.isosplat`], nobody);
    expect(ran.code, ran.stderr).toBe(0);
  });

  test("that is not for everyone is one error without credentials", async () => {
    const error = errorOf(await run(["info", `s3://${bucket}/stores/head.isosplat`], nobody));
    expect(error).toContain("found status 403 (AccessDenied");
    expect(error).toContain("your credentials");
  });

  test.each([
    ["a wrong secret", { AWS_SECRET_ACCESS_KEY: "sesame" }, "SignatureDoesNotMatch"],
    ["another account", { AWS_ACCESS_KEY_ID: "sesame" }, "InvalidAccessKeyId"],
    ["another region", { AWS_REGION: "us-east-1" }, "AuthorizationHeaderMalformed"],
  ])("refused for %s is one error", async (_, env, code) => {
    const address = `s3://${bucket}/stores/head.isosplat`;
    const error = errorOf(await run(["info", address], { ...person, ...env }));
    expect(error).toContain(`${address}: reading failed`);
    expect(error).toContain(code);
  });

  test("refused for a wrong clock is one error that says so", async () => {
    service.clockAhead = 3_600_000;
    const error = errorOf(await run(["info", `s3://${bucket}/stores/head.isosplat`]));
    expect(error).toContain("RequestTimeTooSkewed");
    expect(error).toContain("set this machine's clock");
  });

  test("refused for expired credentials is one error that says so", async () => {
    const body = "<Error><Code>ExpiredToken</Code><Message>expired</Message></Error>";
    proxy.fault = () => ({ kind: "status", status: 403, body });
    const error = errorOf(await run(["info", `s3://${bucket}/stores/head.isosplat`]));
    expect(error).toContain("ExpiredToken");
    expect(error).toContain("get new ones");
    expect(proxy.requests).toHaveLength(1);
  });

  test("is read in spite of resets and requests to slow down", async () => {
    const body = "<Error><Code>SlowDown</Code></Error>";
    proxy.fault = (_path, number) =>
      [{ kind: "reset" } as const, { kind: "status", status: 503, body } as const][number % 3];
    const output = join(folder, "points.npy");
    const ran = await run([
      "extract",
      `s3://${bucket}/stores/head.isosplat`,
      "-i",
      "100.5",
      "-o",
      output,
    ]);
    expect(ran.code, ran.stderr).toBe(0);
    expect(readFileSync(output).length).toBeGreaterThan(1000);
    expect(service.refused).toEqual([]);
  });

  test.each([
    "s3://volumes",
    "s3://volumes/",
    "s3://UPPER/key",
    "s3:///key",
    "s3://volumes/a/../b",
    "s3://volumes/.",
  ])("expects an address with a bucket and a key, not %s", async (address) => {
    expect(errorOf(await run(["info", address]), 2)).toContain("expected s3://BUCKET/KEY");
  });

  test.each([
    "s3://AKIA:sesame@volumes/a.isosplat",
    "s3://sesame@volumes/a.isosplat",
    "s3://sesame:9000/volumes/a.isosplat",
  ])("is not asked for with credentials or a port in the address: %s", async (address) => {
    const error = errorOf(await run(["info", address]), 2);
    expect(error).toContain("expected s3://BUCKET/KEY, found a user name, a password or a port");
  });

  test.each([
    ["https://user:sesame@host", "a user name or a password"],
    ["https://:sesame@host", "a user name or a password"],
    ["https://host?sesame", "parameters"],
    ["ftp://sesame", "cannot be parsed"],
  ])("expects a host as endpoint, not %s", async (endpoint, found) => {
    const args = ["info", `s3://${bucket}/a`];
    const option = errorOf(await runProgram([...args, "--endpoint", endpoint], person), 2);
    expect(option).toContain("--endpoint: expected http://HOST or https://HOST");
    expect(option).toContain(found);
    const variable = errorOf(await runProgram(args, { ...person, AWS_ENDPOINT_URL: endpoint }), 2);
    expect(variable).toContain("AWS_ENDPOINT_URL, or endpoint_url of the profile: expected");
    expect(variable).toContain(found);
  });
});
