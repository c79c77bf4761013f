// node check.js MODEL.glb CHROMIUM SCREENSHOT.png SECONDS...
// Validates the model with the Khronos validator, plays it in three.js, and prints what it saw as one JSON line.
import { createServer } from 'node:http';
import { readFile } from 'node:fs/promises';
import { extname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';
import validator from 'gltf-validator';

const FOLDER = fileURLToPath(new URL('.', import.meta.url));
const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.glb': 'model/gltf-binary' };
// Software rendering; and no calls home, which a closed network would only refuse.
const ARGUMENTS = [
  '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--no-sandbox', '--disable-quic', '--no-first-run',
  '--disable-background-networking', '--disable-component-update', '--disable-sync',
];

const [model, executablePath, screenshot, ...times] = process.argv.slice(2);
const bytes = await readFile(model);
const report = await validator.validateBytes(new Uint8Array(bytes), { maxIssues: 50 });

const server = createServer(async (request, response) => {
  const path = normalize(decodeURIComponent(new URL(request.url, 'http://localhost').pathname));
  try {
    const body = path === '/model.glb' ? bytes : await readFile(join(FOLDER, path));
    response.writeHead(200, { 'content-type': TYPES[extname(path)] ?? 'application/octet-stream' }).end(body);
  } catch {
    response.writeHead(404).end();
  }
});
await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));

const browser = await chromium.launch({ executablePath, args: ARGUMENTS });
try {
  const page = await browser.newPage({ viewport: { width: 480, height: 600 } });
  const complaints = [];
  page.on('pageerror', (error) => complaints.push(String(error)));
  page.on('console', (line) => { if (['error', 'warning'].includes(line.type())) complaints.push(line.text()); });
  await page.goto(`http://127.0.0.1:${server.address().port}/page.html`);
  await page.waitForFunction('window.ready', null, { timeout: 120_000 });
  const moments = [];
  for (const seconds of times) {
    moments.push(await page.evaluate((t) => window.showAt(t), Number(seconds)));
  }
  await page.screenshot({ path: screenshot });
  const facts = await page.evaluate(() => window.facts);
  console.log(JSON.stringify({ issues: report.issues, info: report.info, facts, moments, complaints }));
} finally {
  await browser.close();
  server.close();
}
