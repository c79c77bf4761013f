// Folds of the skin: shade on its texture where channels gather it, as mien's own pictures have them (docs/pictures.md).
import { shaded } from 'mien-viewer';
import { DataTexture, LinearFilter, RedFormat, type Material, type Mesh } from 'three';

/** As the server tells it. */
export interface FoldData { material: string; size: number; tint: [number, number, number]; folds: { drivers: Record<string, number>; texels: string; shade: string }[] }

const ZERO = 128;
const bytes = (packed: string): Uint8Array<ArrayBuffer> => Uint8Array.from(atob(packed), (sign) => sign.charCodeAt(0));

export class Folds {
  private readonly texture: DataTexture;
  private readonly folds: { drivers: [string, number][]; texels: Uint32Array; shade: Int8Array }[];
  private readonly sum: Float32Array;
  private shown = '';

  constructor(private readonly told: FoldData) {
    const { size } = told;
    this.sum = new Float32Array(size * size);
    this.texture = new DataTexture(new Uint8Array(size * size).fill(ZERO), size, size, RedFormat);
    this.texture.magFilter = this.texture.minFilter = LinearFilter;
    this.texture.needsUpdate = true;
    this.folds = told.folds.map(({ drivers, texels, shade }) => ({ drivers: Object.entries(drivers), texels: new Uint32Array(bytes(texels).buffer), shade: new Int8Array(bytes(shade).buffer) }));
  }

  /** Has the skin among some meshes show them. */
  lieOn(meshes: readonly Mesh[]): void {
    for (const { material } of meshes) for (const one of Array.isArray(material) ? material : [material]) if (one.name === this.told.material && 'map' in one && one.map !== null) this.cover(one);
  }

  private cover(material: Material): void {
    const { texture, told: { tint } } = this;
    shaded(material, (shader) => {
      shader.uniforms['mienFolds'] = { value: texture };
      shader.uniforms['mienTint'] = { value: tint };
      shader.fragmentShader = shader.fragmentShader.replace('void main() {', 'uniform sampler2D mienFolds;\nuniform vec3 mienTint;\nvoid main() {').replace('#include <map_fragment>', DARKER);
    });
  }

  /** Folds as deep as a pose has them: skin gathers a little before it folds. */
  pose(channels: readonly string[], values: ArrayLike<number>): void {
    const weights = this.folds.map(({ drivers }) => {
      const total = drivers.reduce((sum, [name, share]) => sum + share * (values[channels.indexOf(name)] ?? 0), 0);
      return Math.round(Math.min(Math.max(total, 0), 1) ** 1.5 * 64) / 64;
    });
    const now = weights.join();
    if (now === this.shown) return;
    this.shown = now;
    const { sum, texture: { image } } = this;
    sum.fill(0);
    this.folds.forEach(({ texels, shade }, place) => {
      const weight = weights[place] as number;
      if (weight > 0) for (let i = 0; i < texels.length; i++) { const at = texels[i] as number; sum[at] = (sum[at] as number) + weight * (shade[i] as number); }
    });
    const data = image.data as Uint8Array;
    for (const { texels } of this.folds) for (let i = 0; i < texels.length; i++) { const at = texels[i] as number; data[at] = Math.min(Math.max(ZERO + (sum[at] as number), 1), 255); }
    this.texture.needsUpdate = true;
  }

  dispose(): void { this.texture.dispose(); }
}

const DARKER = /* glsl */ `
#include <map_fragment>
diffuseColor.rgb *= pow( max( 1.0 - ( texture2D( mienFolds, vMapUv ).r * 255.0 - 128.0 ) / 127.0 * mienTint, 0.0 ), vec3( 2.2 ) );
`;
