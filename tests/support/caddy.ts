/** Caddy in front of a server, with the configuration that the packages have. */
import { type ChildProcess, spawn, spawnSync } from "node:child_process";
import { once } from "node:events";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { connect as connectTls } from "node:tls";
import { fileURLToPath } from "node:url";
import { chromiumArgumentsFor, makeCertificate } from "./certificate.ts";
import { freePort } from "./nginx.ts";

const root = fileURLToPath(new URL("../..", import.meta.url));
const isThere = (program: string) => spawnSync(program, ["version"]).error === undefined;

/** Whether Caddy is installed, and openssl, which makes its certificate. */
export const hasCaddy = isThere("caddy") && isThere("openssl");

export interface Caddy {
  /** The port for TCP and UDP. */
  port: number;
  /** The certificate of volumes.example, in PEM. */
  certificate: Buffer;
  /** Arguments that make Chromium accept this certificate, and find volumes.example here. */
  chromiumArguments: string[];
  stop(): Promise<void>;
}

/** Starts Caddy for volumes.example in front of a server. `folder`: for Caddy's files. */
export async function startCaddy(folder: string, serverPort: number): Promise<Caddy> {
  const port = await freePort();
  const { certificate, key } = makeCertificate(folder, "volumes.example");
  // Only ports, addresses and the certificate differ from the configuration in the packages.
  const site = readFileSync(join(root, "native/packaging/Caddyfile"), "utf8")
    .replace("127.0.0.1:8080", `127.0.0.1:${serverPort}`)
    .replace("volumes.example {", `volumes.example {\n\ttls ${certificate} ${key}`);
  const configuration = join(folder, "Caddyfile");
  writeFileSync(
    configuration,
    `{
      admin off
      auto_https disable_redirects
      default_bind 127.0.0.1
      https_port ${port}
    }
    ${site}`,
  );
  const proxy = spawn("caddy", ["run", "--config", configuration, "--adapter", "caddyfile"], {
    stdio: ["ignore", "ignore", "pipe"],
    env: { ...process.env, HOME: folder, XDG_DATA_HOME: folder, XDG_CONFIG_HOME: folder },
  });
  let errors = "";
  proxy.stderr.on("data", (text) => {
    errors += text;
  });
  for (let attempt = 0; !(await answers(port)); ++attempt) {
    if (attempt === 200 || proxy.exitCode !== null) {
      await stop(proxy);
      throw new Error(`Caddy did not start: ${errors}`);
    }
    await new Promise((next) => setTimeout(next, 50));
  }
  return {
    port,
    certificate: readFileSync(certificate),
    chromiumArguments: chromiumArgumentsFor(readFileSync(certificate), "volumes.example"),
    stop: () => stop(proxy),
  };
}

async function answers(port: number): Promise<boolean> {
  const socket = connectTls({
    port,
    host: "127.0.0.1",
    servername: "volumes.example",
    rejectUnauthorized: false,
  });
  const isOpen = await Promise.race([
    once(socket, "secureConnect").then(() => true),
    once(socket, "close").then(() => false),
  ]).catch(() => false);
  socket.destroy();
  return isOpen;
}

async function stop(child: ChildProcess): Promise<void> {
  if (child.exitCode !== null) return;
  child.kill("SIGTERM");
  await once(child, "exit");
}
