import { describe, expect, it } from 'vitest';
import told from './golden/tree.json';
import { deformed, isSkeletal, matrices, painted, runsOf, withWeights, type Influences, type TreeData } from '../src/rig/tree';

interface Golden { config: TreeData; influences: Influences; rest: Record<string, number[][]>; cases: { values: Record<string, number>; vertices: Record<string, number[][]> }[] }
const golden = told as unknown as Golden;

describe('the parameter tree, against ParameterTree.deform', () => {
  golden.cases.forEach(({ values, vertices }) => {
    it(JSON.stringify(values), () => {
      const moved = matrices(golden.config, new Map(Object.entries(values)));
      for (const [part, rest] of Object.entries(golden.rest)) {
        const found = deformed(golden.config, golden.influences, part, Float32Array.from(rest.flat()), moved);
        vertices[part]?.flat().forEach((value, i) => expect(found[i]).toBeCloseTo(value, 3));
      }
    });
  });
  it('knows its groups', () => {
    const skeletal = golden.config.parameters.filter((one) => isSkeletal(golden.config, one)).map(({ name }) => name);
    expect(skeletal).toEqual(['head', 'jaw', 'trunk']);
  });
});

describe('a brush', () => {
  const rest = Float32Array.from([0, 0, 0, 10, 0, 0, -10, 0, 0, 0, 30, 0]);
  const brush = { centre: [10, 0, 0] as [number, number, number], radius: 8, strength: 0.5, mirrored: false, erase: false };
  it('lays weights on, most in its middle, never past one', () => {
    expect(painted(undefined, rest, brush)).toEqual({ vertices: [1], weights: [0.5] });
    expect(painted({ vertices: [1], weights: [0.8] }, rest, brush)).toEqual({ vertices: [1], weights: [1] });
  });
  it('paints both sides, and takes away', () => {
    expect(painted(undefined, rest, { ...brush, mirrored: true }).vertices).toEqual([1, 2]);
    expect(painted({ vertices: [0, 1], weights: [0.3, 0.4] }, rest, { ...brush, erase: true })).toEqual({ vertices: [0], weights: [0.3] });
  });
  it('is written as runs', () => {
    expect(runsOf({ vertices: [5, 3, 4, 9], weights: [0.5, 0.5, 0.5, 0.00001] })).toEqual([[3, 5, 0.5]]);
    const parameter = golden.config.parameters[0]!;
    expect(withWeights(parameter, { skin: { vertices: [1], weights: [1] }, eye: { vertices: [], weights: [] } }).regions).toEqual([{ shape: 'weights', part: 'skin', weights: [[1, 1, 1]] }]);
  });
});
