// How a face takes light: skin, wet eyes, and eyes that stay behind shut lids. Hand-made by eye.
import { Box3, Color, MeshPhysicalMaterial, MeshStandardMaterial, Vector3, type Material, type Mesh, type Object3D } from 'three';

const SKIN = /skin|face|head|body/i;
const EYE = /eye|cornea|sclera|iris/i;
const NOT_EYE = /lash|brow|lid|shadow|socket|tear|glass/i;
const NOT_SKIN = /hair|brow|lash|teeth|tooth|tongue|eye|cloth|shirt/i;
const WET = /teeth|tooth|tongue|gum|caruncle/i;
const BEHIND = 0.07; // of an eyeball's width: so far behind itself it counts in the depth of the picture

/**
 * Gives the meshes below an object surfaces like those of mien's own pictures, by the names of meshes and materials: light runs a
 * little around the edge of skin into the shade, red farthest; eyes, teeth and tongue are wet; and an eyeball counts as lying
 * a little deeper than it does, so that no corner of it shows through a lid that shuts tightly over it.
 *
 * @param made another surface in the place of one, before that (a plainer one, say)
 */
export function dressFace(object: Object3D, made: (material: Material) => Material = (material) => material): void {
  object.traverse((part) => {
    const mesh = part as Mesh;
    if (!mesh.isMesh) return;
    const dress = (material: Material): Material => {
      const dressed = surface(made(material));
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

function surface(material: Material): Material {
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
