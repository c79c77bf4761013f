// node survive.mjs PACKAGE PYTHON CHROMIUM FOLDER FACES...
// Kills the server in the middle of the work, twice, and looks whether anything is lost; then keys by the dozen, a
// comparison, other makers' faces, a scan by axe in three sizes. Prints what was seen as one JSON line.
import { spawn } from 'node:child_process';
import { createRequire } from 'node:module';
import { createServer } from 'node:net';
import { join } from 'node:path';

const [packageFolder, python, executablePath, folder, ...faces] = process.argv.slice(2);
const require = createRequire(join(packageFolder, 'package.json'));
const { chromium } = require('playwright-core');
const ARGUMENTS = [
  '--headless', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--no-sandbox', '--disable-quic', '--no-first-run',
  '--disable-background-networking', '--disable-component-update', '--disable-sync', '--autoplay-policy=no-user-gesture-required',
];
const seen = { complaints: [], axe: {}, small: {}, faces: {} };
const port = await new Promise((resolve) => {
  const probe = createServer().listen(0, '127.0.0.1', () => { const { port: free } = probe.address(); probe.close(() => resolve(free)); });
});
const address = `http://127.0.0.1:${port}/`;
let server;
const open = (kept) => new Promise((resolve, reject) => {
  server = spawn(python, ['-m', 'mien', 'studio', '--no-browser', '--port', String(port), '--folder', join(folder, kept)]);
  server.stdout.once('data', resolve);
  server.once('exit', () => reject(new Error('the studio has ended')));
});
const kill = () => new Promise((resolve) => { server.removeAllListeners('exit'); server.once('exit', resolve); server.kill('SIGKILL'); });

await open('first');
const browser = await chromium.launch({ executablePath, args: ARGUMENTS });
try {
  const context = await browser.newContext({ viewport: { width: 1100, height: 700 }, deviceScaleFactor: 0.5, colorScheme: 'light' });
  const page = await context.newPage();
  page.setDefaultTimeout(90_000);
  page.on('pageerror', (error) => seen.complaints.push(String(error)));
  const idle = async () => {
    await page.waitForFunction(() => document.querySelector('.told').childElementCount === 0);
    await page.waitForFunction(() => document.body.dataset.kept !== 'false');
  };
  const keys = () => page.evaluate(async () => {
    const { take } = window.mienStats.shown();
    const { steps, at } = await (await fetch(`/api/takes/${take}/steps`)).json();
    return steps[at].layer.edits.flatMap((edit) => (edit.kind === 'channel' ? [[edit.channel, edit.keys.length]] : []));
  });
  const lane = async (name) => page.locator(`.channel[data-lane=${name}] .body`).boundingBox();
  const key = async (x, y = 12) => { const box = await lane('jawOpen'); await page.mouse.dblclick(box.x + box.width * x, box.y + y); };

  await page.goto(address);
  await page.waitForSelector('body[data-ready]');
  await page.fill('#field-text', 'I never said that.');
  await page.click('#perform');
  await page.waitForFunction(() => window.mienStats.shown() !== null);
  await idle();
  await key(0.3);
  await idle();
  const take = await page.evaluate(() => window.mienStats.shown().take);

  // The server is killed; what is done meanwhile waits in the page, and arrives when the server is back.
  await kill();
  await key(0.45);
  await key(0.6);
  await page.waitForSelector('.toast:not([hidden])');
  seen.told = await page.locator('.toast').innerText();
  await open('first');
  await idle();
  seen.afterKill = await keys();
  await page.reload();
  await page.waitForSelector('body[data-ready]');
  await idle();
  seen.afterReload = { same: (await page.evaluate(() => window.mienStats.shown()?.take)) === take, keys: await keys() };

  // A second window sees the same, and what it changes is seen in the first.
  const other = await context.newPage();
  await other.goto(address);
  await other.waitForSelector('body[data-ready]');
  seen.secondWindow = (await other.evaluate(() => window.mienStats.shown()?.take)) === take;
  await other.keyboard.press('Control+z');
  await other.waitForFunction(() => document.body.dataset.kept === 'true');
  await other.close();
  await page.evaluate(() => window.dispatchEvent(new Event('focus')));
  await page.waitForFunction(() => document.querySelectorAll('.channel[data-lane=jawOpen] .handle').length === 2);

  // A new server in another folder has never seen the take: the page hands it over.
  await kill();
  await open('second');
  await key(0.75);
  await idle();
  seen.handedBack = await keys();
  seen.address = page.url().endsWith(`#take=${take}`);

  // Keys by the dozen: chosen by a rectangle, moved, copied, pasted, mirrored.
  await page.locator('.channels summary').click();
  await page.getByLabel('mouthSmileRight', { exact: true }).setChecked(false);
  await page.keyboard.press('Escape');
  const box = await lane('jawOpen');
  await page.mouse.move(box.x + box.width * 0.2, box.y + 1);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width * 0.9, box.y + 45);
  await page.mouse.up();
  seen.chosen = await page.locator('.handle.chosen').count();
  await page.keyboard.press('Control+c');
  await page.keyboard.press('Home');
  await page.keyboard.press('Control+v');
  await idle();
  seen.pasted = await keys();
  await page.keyboard.press('Control+a');
  await page.keyboard.press('Delete');
  await idle();
  seen.deleted = await keys();
  await page.keyboard.press('Control+z');
  await idle();
  seen.undone = await keys();
  const smile = await lane('mouthSmileLeft');
  await page.mouse.dblclick(smile.x + smile.width * 0.5, smile.y + 14);
  await idle();
  await page.mouse.click(smile.x + smile.width * 0.5, smile.y + 14, { button: 'right' });
  seen.menuCut = await page.locator('.context-menu').evaluate((menu) => menu.scrollWidth > menu.clientWidth + 1 || [...menu.querySelectorAll('button')].some((entry) => entry.getBoundingClientRect().right > menu.getBoundingClientRect().right));
  await page.screenshot({ path: join(folder, 'menu.png') });
  await page.getByRole('menuitem', { name: 'Copy to the other side of the face' }).click();
  await idle();
  seen.mirrored = (await keys()).map(([name]) => name);

  // A copy is compared with the take.
  await page.click('#tab-takes');
  await page.getByLabel(/^Duplicate/).first().click();
  await page.waitForFunction((before) => window.mienStats.shown().take !== before, take);
  await idle();
  await page.getByLabel(/^Compare with/).first().click();
  await page.waitForSelector('.compare:not([hidden])');
  await idle();
  await page.waitForTimeout(500);
  await page.screenshot({ path: join(folder, 'compare.png') });
  await page.locator('.compare button', { hasText: 'A' }).click();

  // Faces of other makers.
  for (const face of faces) {
    const name = face.split('/').pop();
    await page.setInputFiles('#field-face', face);
    await page.waitForFunction((wanted) => document.querySelector('.report h3')?.textContent === wanted || !document.querySelector('#fault-face').hidden, name);
    await idle();
    await page.click('#tab-face');
    await page.waitForTimeout(300);
    seen.faces[name] = await page.locator('.report, #fault-face').allInnerTexts();
    await page.screenshot({ path: join(folder, `face-${name}.png`) });
  }

  // axe, and targets that are too small, at three sizes.
  for (const [name, width, height] of [['desk', 1280, 720], ['upright', 390, 844], ['lying', 844, 390]]) {
    await page.setViewportSize({ width, height });
    for (const tab of name === 'desk' ? ['line', 'takes', 'edits', 'face', 'export'] : ['line', 'takes']) {
      await page.click(`#tab-${tab}`);
      await page.waitForTimeout(200);
      await page.screenshot({ path: join(folder, `${name}-${tab}.png`) });
      await page.evaluate(require('node:fs').readFileSync(require.resolve('axe-core/axe.min.js'), 'utf8'));
      const found = await page.evaluate(() => window.axe.run(document, { runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa'] }));
      for (const { id, nodes } of found.violations) (seen.axe[id] ??= []).push(`${name} ${tab}: ${nodes.slice(0, 3).map(({ html }) => html.slice(0, 120)).join(' | ')}`);
      const small = await page.evaluate(() => [...document.querySelectorAll('button, select, summary, a.button, input:not([type=checkbox], [type=file], [type=range])')].filter((element) => {
        const { width: wide, height: tall } = element.getBoundingClientRect();
        return wide > 0 && getComputedStyle(element).opacity !== '0' && (wide < 23.5 || tall < 23.5);
      }).map((element) => element.id || element.getAttribute('aria-label') || element.textContent));
      if (small.length > 0) seen.small[`${name} ${tab}`] = small;
    }
    if (name !== 'desk') {
      if (await page.locator('#tab-timeline').isVisible()) await page.click('#tab-timeline');
      await page.screenshot({ path: join(folder, `${name}-timeline.png`) });
    }
    seen[name] = await page.evaluate(() => document.documentElement.scrollWidth);
  }
  console.log(JSON.stringify(seen));
} catch (problem) {
  console.log(JSON.stringify({ ...seen, failed: String(problem) }));
} finally {
  await browser.close();
  await kill();
}
