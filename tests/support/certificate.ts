import { execFileSync } from "node:child_process";
import { createHash, X509Certificate } from "node:crypto";
import { join } from "node:path";

/** Files, in PEM. */
export interface CertificateFiles {
  certificate: string;
  key: string;
}

/** Makes a self-signed certificate for a host name, in a folder. Needs openssl. */
export function makeCertificate(folder: string, host: string): CertificateFiles {
  const files = { certificate: join(folder, "certificate"), key: join(folder, "key") };
  // biome-ignore format: options with their values
  execFileSync("openssl", [
    "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes",
    "-subj", `/CN=${host}`, "-addext", `subjectAltName=DNS:${host}`,
    "-days", "30", "-keyout", files.key, "-out", files.certificate,
  ], { stdio: "ignore" });
  return files;
}

/** Arguments that make Chromium accept this certificate, and find its host on this machine. */
export function chromiumArgumentsFor(certificate: Buffer, host: string): string[] {
  const hash = createHash("sha256")
    .update(new X509Certificate(certificate).publicKey.export({ type: "spki", format: "der" }))
    .digest("base64");
  return [
    `--ignore-certificate-errors-spki-list=${hash}`,
    `--host-resolver-rules=MAP ${host} 127.0.0.1`,
  ];
}
