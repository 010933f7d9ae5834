import { BufferAttribute, BufferGeometry, GLSL3, Mesh, RawShaderMaterial } from "three";

/** The background of the desktop window: lighter at the top, in sRGB. */
const kVertexShader = `
in vec2 at;
out float height;
void main() {
  height = at.y * 0.5 + 0.5;
  gl_Position = vec4(at, 1.0, 1.0);
}`;
const kFragmentShader = `
precision highp float;
in float height;
out vec4 pixel;
void main() {
  // Dithered, because steps of such a slow gradient show on large screens.
  float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
  pixel = vec4(mix(vec3(0.10, 0.11, 0.13), vec3(0.30, 0.34, 0.39), height) + noise / 255.0, 1.0);
}`;

/** Makes a mesh that fills the picture behind everything else. Add it to the scene first. */
export function makeBackground(): Mesh<BufferGeometry, RawShaderMaterial> {
  const geometry = new BufferGeometry();
  geometry.setAttribute("at", new BufferAttribute(new Float32Array([-1, -1, 3, -1, -1, 3]), 2));
  geometry.setIndex([0, 1, 2]);
  const material = new RawShaderMaterial({
    glslVersion: GLSL3,
    vertexShader: kVertexShader,
    fragmentShader: kFragmentShader,
    depthTest: false,
    depthWrite: false,
  });
  const mesh = new Mesh(geometry, material);
  mesh.frustumCulled = false;
  mesh.matrixAutoUpdate = false;
  return mesh;
}
