// node tools/studio_pictures.mjs ADDRESS FOLDER [CHROMIUM] [FACE.glb]
// The pictures of docs/studio.md, taken in a studio that runs at ADDRESS: docs/pictures/studio*.jpg. FACE.glb is a face
// of other makers for the picture of the deformation editor; without it that shows the default face.
import { createRequire } from 'node:module';
import { join } from 'node:path';

const [address, folder, executablePath = '/usr/bin/chromium', face] = process.argv.slice(2);
const { chromium } = createRequire(new URL('../studio/package.json', import.meta.url))('playwright-core');
const browser = await chromium.launch({ executablePath, args: ['--headless', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
  '--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking', '--autoplay-policy=no-user-gesture-required'] });
try {
  const page = await (await browser.newContext({ viewport: { width: 1280, height: 760 }, colorScheme: 'dark' })).newPage();
  page.setDefaultTimeout(300_000);
  const idle = async (wait = 1500) => { await page.waitForFunction(() => document.querySelector('.told').childElementCount === 0); await page.waitForTimeout(wait); };
  const shot = async (name) => { await page.screenshot({ path: join(folder, `studio${name}.jpg`), type: 'jpeg', quality: 82 }); console.log(name || 'studio'); };
  /** To the moment in the second half at which the mouth is widest open and the eyes are. */
  const seek = async () => {
    const share = await page.evaluate(() => {
      const { channels, values } = window.mienStats.shown();
      const [width, frames] = [channels.length, values.length / channels.length];
      const at = (frame, name) => values[frame * width + channels.indexOf(name)];
      const worth = (frame) => at(frame, 'jawOpen') - 5 * at(frame, 'eyeBlinkLeft');
      let best = Math.round(frames / 2);
      for (let frame = best; frame < 0.85 * frames; frame++) if (worth(frame) > worth(best)) best = frame;
      return best / frames;
    });
    const box = await page.locator('.wave .body').boundingBox();
    await page.mouse.click(box.x + 12 + (box.width - 24) * share, box.y + 20);
    await page.waitForTimeout(1200);
  };

  await page.goto(`${address}?quality=full`);
  await page.waitForSelector('body[data-ready]');
  await idle(4000);
  await page.fill('#field-text', 'I never said that. Maybe five people heard my voice!');
  await page.click('#perform');
  await page.waitForFunction(() => window.mienStats.shown() !== null);
  await idle();
  await page.click('[data-emotion=happy]');
  await idle();
  const jaw = page.locator('.channel[data-lane=jawOpen]');
  await jaw.getByLabel('Taller or lower').evaluate((press) => press.click());
  await page.waitForTimeout(300);
  const lane = await jaw.locator('.body').boundingBox();
  for (const [x, y] of [[0.2, 60], [0.33, 25], [0.45, 100], [0.6, 40]]) { await page.mouse.dblclick(lane.x + lane.width * x, lane.y + y); await idle(300); }
  for (const [x, y, tangent] of [[0.33, 25, 'step'], [0.6, 40, 'linear']]) {
    await page.mouse.click(lane.x + lane.width * x, lane.y + y, { button: 'right' });
    await page.getByRole('menuitemradio', { name: tangent }).click();
    await idle(300);
  }
  await seek();
  await shot('');
  await page.fill('#field-text', 'I never said that. [sad] Maybe five people <');
  await page.locator('#field-text').press('End');
  await shot('-tags');
  await page.fill('#field-text', 'I never said that. Maybe five people heard my voice!');
  await page.getByLabel('Spectrogram').evaluate((press) => press.click());
  await page.waitForTimeout(500);
  const low = await jaw.locator('.body').boundingBox();
  await page.mouse.click(low.x + low.width * 0.33, low.y + 25, { button: 'right' });
  await page.waitForTimeout(500);
  await shot('-keys');
  await page.keyboard.press('Escape');
  const words = await page.locator('.words .body').boundingBox();
  await page.mouse.click(words.x + words.width * 0.28, words.y + 10, { button: 'right' });
  await page.waitForTimeout(500);
  await shot('-words');
  await page.keyboard.press('Escape');
  await page.click('#tab-edits');
  await shot('-edits');
  await page.click('#tab-face');
  await page.waitForTimeout(2500);
  await shot('-faces');
  await page.click('[data-face=amara]');
  await page.waitForSelector('[data-face=amara][aria-pressed=true]');
  await page.click('#tab-line');
  await idle(9000);
  await shot('-cast');
  for (const [name, width, height] of [['-lying', 844, 390], ['-upright', 390, 844]]) {
    await page.setViewportSize({ width, height });
    await page.waitForTimeout(2500);
    await shot(name);
  }
  await page.setViewportSize({ width: 1280, height: 760 });
  if (face === undefined) await page.locator('[data-face=default]').evaluate((press) => press.click());
  else await page.setInputFiles('#field-face', face);
  await idle(3000);
  await page.click('#tab-rig');
  await page.click('#load-tree');
  await page.waitForFunction(() => window.mienStats.tree());
  await idle();
  await page.selectOption('#field-parameter', 'jaw');
  await page.locator('#field-value').evaluate((slider) => { slider.value = '14'; slider.dispatchEvent(new Event('input', { bubbles: true })); });
  await page.waitForTimeout(2000);
  await shot('-rig');
} finally {
  await browser.close();
}
