// Peer: three.js in headless Chromium. Serves three_page.html and the subject, and takes what the page measures.
//
//     node three_shadows.mjs NODE_MODULES CHROMIUM FOLDER     # README.md says what to install

import { createReadStream, existsSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { dirname, extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";

const [modules, chromium, folder] = process.argv.slice(2);
const { chromium: browserType } = createRequire(join(modules, "x.js"))("playwright-core");

const ROOTS = { "/modules/": modules, "/subject/": folder, "/": dirname(fileURLToPath(import.meta.url)) };
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".json": "application/json" };
const MINUTES = 14;

// WebGL on SwiftShader, a software driver: --no-sandbox since a container's root cannot have one.
const FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"];

function serve(request, response) {
  const path = normalize(decodeURIComponent(new URL(request.url, "http://localhost").pathname));
  if (request.method === "POST") {
    const parts = [];
    request.on("data", (part) => parts.push(part));
    request.on("end", () => {
      writeFileSync(join(folder, path), Buffer.concat(parts));
      response.end();
    });
    return;
  }
  const root = Object.keys(ROOTS).find((prefix) => path.startsWith(prefix));
  const file = join(ROOTS[root], path.slice(root.length));
  if (!existsSync(file)) {
    response.writeHead(404).end();
    return;
  }
  response.writeHead(200, { "Content-Type": TYPES[extname(file)] ?? "application/octet-stream" });
  createReadStream(file).pipe(response);
}

const server = createServer(serve).listen(0, "127.0.0.1");
await new Promise((resolve) => server.once("listening", resolve));
const browser = await browserType.launch({ executablePath: chromium, args: FLAGS });
try {
  const page = await browser.newPage();
  page.on("pageerror", (error) => console.error(String(error)));
  page.on("console", (message) => console.error(message.text()));
  await page.goto(`http://127.0.0.1:${server.address().port}/three_page.html`);
  await page.waitForFunction(() => window.finished, null, { timeout: 60_000 * MINUTES });
  const failure = await page.evaluate(() => window.failure);
  if (failure) {
    console.error(failure);
    process.exitCode = 1;
  }
} finally {
  await browser.close();
  server.close();
}
