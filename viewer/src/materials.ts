// How a face takes light: skin, wet eyes, and eyes that stay behind shut lids. Hand-made by eye.
import { Box3, Color, MeshPhysicalMaterial, MeshStandardMaterial, Vector3, type Material, type Mesh, type Object3D } from 'three';
import { findDepth, findThin, pores, tilesOf } from './flesh.js';

const SKIN = /skin|face|head|body/i;
const EYE = /eye|cornea|sclera|iris/i;
const NOT_EYE = /lash|brow|lid|shadow|socket|tear|glass/i;
const NOT_SKIN = /hair|brow|lash|teeth|tooth|tongue|eye|cloth|shirt/i;
const WET = /teeth|tooth|tongue|gum|caruncle/i;
const BEHIND = 0.07; // of an eyeball's width: so far behind itself it counts in the depth of the picture
const EYEBALL_MM = 28; // with what is built around it

/**
 * Gives the meshes below an object surfaces like those of mien's own pictures, by the names of meshes and materials: light runs a
 * little around the edge of skin into the shade, red farthest, and through ears; skin has pores where the picture is large enough
 * to show them; eyes, teeth and tongue are wet, and darker the deeper they lie in the mouth; and an eyeball counts as lying a
 * little deeper than it does, so that no corner of it shows through a lid that shuts tightly over it.
 *
 * @param made another surface in the place of one, before that (a plainer one, say)
 */
export function dressFace(object: Object3D, made: (material: Material) => Material = (material) => material): void {
  const millimetre = millimetreOf(object);
  object.traverse((part) => {
    const mesh = part as Mesh;
    if (!mesh.isMesh) return;
    const dress = (material: Material): Material => {
      const dressed = surface(made(material), mesh, millimetre);
      if (!isEye(mesh.name, material.name)) return dressed;
      const own = dressed === material ? material.clone() : dressed; // the skin may have the same
      sink(own, BEHIND * widthOf(mesh));
      return own;
    };
    mesh.material = Array.isArray(mesh.material) ? mesh.material.map(dress) : dress(mesh.material);
  });
}

const isEye = (...names: string[]): boolean => names.some((name) => EYE.test(name)) && !names.some((name) => NOT_EYE.test(name));

/** The width of one eye, in the units of the scene: both may be one mesh. */
function widthOf(mesh: Mesh): number {
  mesh.updateWorldMatrix(true, false);
  mesh.geometry.computeBoundingBox();
  const { y, z } = (mesh.geometry.boundingBox as Box3).clone().applyMatrix4(mesh.matrixWorld).getSize(new Vector3());
  return Math.max(y, z);
}

/** What a millimetre is in the world, as eyeballs have it; 0 where there are none. */
function millimetreOf(object: Object3D): number {
  let width = 0;
  object.traverse((part) => {
    const mesh = part as Mesh;
    if (mesh.isMesh && [mesh.material].flat().some((material) => isEye(mesh.name, material.name))) width = Math.max(width, widthOf(mesh));
  });
  return width / EYEBALL_MM;
}

function surface(material: Material, mesh: Mesh, millimetre: number): Material {
  if (WET.test(material.name) && !isEye(material.name)) shadeMouth(material, mesh);
  if (!(material instanceof MeshStandardMaterial)) return material;
  material.envMapIntensity = 1;
  const { name } = material;
  const [eye, wet, skin] = [isEye(name), WET.test(name), SKIN.test(name) && !NOT_SKIN.test(name)];
  if (!eye && !wet && !skin) return material;
  const made = new MeshPhysicalMaterial();
  MeshStandardMaterial.prototype.copy.call(made, material);
  made.name = name;
  if (skin) {
    made.roughness = Math.max(material.roughness, 0.5);
    made.specularIntensity = 0.7;
    made.sheen = 0.22;
    made.sheenRoughness = 0.45;
    made.sheenColor = new Color(0xffc9ae);
    shaded(made, (shader) => { shader.fragmentShader = shader.fragmentShader.replace('#include <lights_physical_pars_fragment>', SCATTER); });
    if (millimetre > 0) flesh(made, mesh, millimetre);
  } else { // a film of water over what is matt itself
    made.roughness = Math.max(material.roughness, 0.45);
    made.clearcoat = eye ? 1 : 0.6;
    made.clearcoatRoughness = eye ? 0.03 : 0.18;
  }
  return made;
}

type Shader = Parameters<Material['onBeforeCompile']>[0];

/** Changes a material's shader, after what has changed it before. */
export function shaded(material: Material, change: (shader: Shader) => void): void {
  const [before, key] = [material.onBeforeCompile, material.customProgramCacheKey()];
  material.onBeforeCompile = (shader, renderer) => { before.call(material, shader, renderer); change(shader); };
  material.customProgramCacheKey = () => `${key}${change.toString()}`;
}

/** Teeth, gums and tongue darker, the deeper they lie in the mouth: lips and cheeks keep light away. */
function shadeMouth(material: Material, mesh: Mesh): void {
  findDepth(mesh);
  shaded(material, (shader) => {
    shader.vertexShader = shader.vertexShader.replace('void main() {', 'attribute float mienDeep;\nvarying float vMienDeep;\nvoid main() {\nvMienDeep = mienDeep;');
    shader.fragmentShader = shader.fragmentShader.replace('void main() {', 'varying float vMienDeep;\nvoid main() {').replace('#include <opaque_fragment>', DARK);
  });
}

/** Light through thin skin, and pores. */
function flesh(material: MeshPhysicalMaterial, mesh: Mesh, millimetre: number): void {
  const unit = millimetre / mesh.matrixWorld.getMaxScaleOnAxis();
  findThin(mesh, unit);
  const tiles = material.map === null ? 0 : tilesOf(mesh, unit);
  const { texture, steepest } = pores();
  if (mesh.geometry.getAttribute('mienThin') !== undefined) {
    shaded(material, (shader) => {
      shader.vertexShader = shader.vertexShader.replace('void main() {', 'attribute float mienThin;\nvarying float vMienThin;\nvoid main() {\nvMienThin = mienThin;');
      shader.fragmentShader = shader.fragmentShader.replace('#define RE_Direct RE_Direct_Skin', THROUGH);
    });
  }
  if (tiles > 0) {
    shaded(material, (shader) => {
      Object.assign(shader.uniforms, { mienPores: { value: texture }, mienTiles: { value: new Vector3(tiles, steepest, 0) } });
      shader.fragmentShader = shader.fragmentShader.replace('void main() {', 'uniform sampler2D mienPores;\nuniform vec3 mienTiles;\nvoid main() {').replace('#include <normal_fragment_maps>', PORES);
    });
  }
}

function sink(material: Material, depth: number): void {
  shaded(material, (shader) => {
    shader.uniforms['mienDepth'] = { value: depth };
    shader.vertexShader = shader.vertexShader.replace('void main() {', 'uniform float mienDepth;\nvoid main() {').replace('#include <project_vertex>', DEEPER);
  });
}

const DEEPER = /* glsl */ `
#include <project_vertex>
vec4 mienBehind = projectionMatrix * vec4( mvPosition.xyz + normalize( mvPosition.xyz ) * mienDepth, 1.0 );
gl_Position.z = mienBehind.z / mienBehind.w * gl_Position.w;
`;

// three.js's own diffuse term, with the cosine wrapped around by a share per colour (Green 2004, "Real-time approximations
// to subsurface scattering", GPU Gems 16).
const SCATTER = /* glsl */ `
#include <lights_physical_pars_fragment>
#undef RE_Direct
void RE_Direct_Skin( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight ) {
  RE_Direct_Physical( directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
  float plainCosine = dot( geometryNormal, directLight.direction );
  vec3 wrap = vec3( 0.30, 0.12, 0.07 );
  vec3 wrapped = max( ( vec3( plainCosine ) + wrap ) / ( ( 1.0 + wrap ) * ( 1.0 + wrap ) ), vec3( 0.0 ) );
  reflectedLight.directDiffuse += ( wrapped - max( plainCosine, 0.0 ) ) * directLight.color * BRDF_Lambert( material.diffuseContribution );
}
#define RE_Direct RE_Direct_Skin
`;

const DARK = /* glsl */ `
outgoingLight *= mix( 0.52, 0.13, smoothstep( 0.0, 0.7, vMienDeep ) );
#include <opaque_fragment>
`;

// What falls on the other side of thin skin comes through, red most (Dachsbacher & Stamminger 2003, with a thickness that is
// worked out once instead of a map of depths).
const THROUGH = /* glsl */ `
varying float vMienThin;
void RE_Direct_Thin( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight ) {
  RE_Direct_Skin( directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
  float behind = clamp( 2.0 * ( 0.1 - dot( geometryNormal, directLight.direction ) ), 0.0, 1.0 );
  reflectedLight.directDiffuse += vMienThin * behind * vec3( 0.42, 0.09, 0.04 ) * directLight.color * BRDF_Lambert( material.diffuseContribution );
}
#define RE_Direct RE_Direct_Thin
`;

// A pixel of 0.26 mm of skin begins to show pores, one of 0.13 mm shows all of them (bump mapping, Blinn 1978).
const PORES = /* glsl */ `
#include <normal_fragment_maps>
vec2 mienTile = vMapUv * mienTiles.x;
float mienShare = clamp( ( 0.26 - 28.0 * max( length( dFdx( mienTile ) ), length( dFdy( mienTile ) ) ) ) / 0.13, 0.0, 1.0 );
vec3 mienPore = texture2D( mienPores, mienTile ).rgb;
vec3 mienUp = ( viewMatrix * vec4( 0.0, 1.0, 0.0, 0.0 ) ).xyz;
vec3 mienAcross = normalize( cross( mienUp, normal ) + vec3( 1e-6, 0.0, 0.0 ) );
vec2 mienSlope = mienShare * mienTiles.y * ( mienPore.xy * 2.0 - 1.0 );
normal = normalize( normal - mienSlope.x * mienAcross - mienSlope.y * cross( normal, mienAcross ) );
diffuseColor.rgb *= 1.0 - 0.16 * mienShare * mienPore.z;
`;
