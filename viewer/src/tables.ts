// Written by tools/viewer_files.py from mien.channels and src/mien/assets/rigs/names.toml. Do not edit.
export const WEIGHTS: readonly string[] = [
 "eyeBlinkLeft",
 "eyeLookDownLeft",
 "eyeLookInLeft",
 "eyeLookOutLeft",
 "eyeLookUpLeft",
 "eyeSquintLeft",
 "eyeWideLeft",
 "eyeBlinkRight",
 "eyeLookDownRight",
 "eyeLookInRight",
 "eyeLookOutRight",
 "eyeLookUpRight",
 "eyeSquintRight",
 "eyeWideRight",
 "jawForward",
 "jawRight",
 "jawLeft",
 "jawOpen",
 "mouthClose",
 "mouthFunnel",
 "mouthPucker",
 "mouthRight",
 "mouthLeft",
 "mouthSmileLeft",
 "mouthSmileRight",
 "mouthFrownLeft",
 "mouthFrownRight",
 "mouthDimpleLeft",
 "mouthDimpleRight",
 "mouthStretchLeft",
 "mouthStretchRight",
 "mouthRollLower",
 "mouthRollUpper",
 "mouthShrugLower",
 "mouthShrugUpper",
 "mouthPressLeft",
 "mouthPressRight",
 "mouthLowerDownLeft",
 "mouthLowerDownRight",
 "mouthUpperUpLeft",
 "mouthUpperUpRight",
 "browDownLeft",
 "browDownRight",
 "browInnerUp",
 "browOuterUpLeft",
 "browOuterUpRight",
 "cheekPuff",
 "cheekSquintLeft",
 "cheekSquintRight",
 "noseSneerLeft",
 "noseSneerRight",
 "tongueOut",
 "tongueTipUp",
 "tongueBackUp",
 "tongueBladeUp",
 "tongueCurl",
 "browInnerUpLeft",
 "browInnerUpRight",
 "noseFlareLeft",
 "noseFlareRight",
 "noseCompressLeft",
 "noseCompressRight",
 "nasolabialDeepenLeft",
 "nasolabialDeepenRight",
 "mouthSharpPullLeft",
 "mouthSharpPullRight",
 "mouthTightenLeft",
 "mouthTightenRight"
];
export const HEAD: readonly string[] = [
 "headYaw",
 "headPitch",
 "headRoll"
];
export const SPELLINGS: Readonly<Record<string, Readonly<Record<string, number>>>> = {
 "tongueout": {
  "tongueOut": 1.0
 },
 "mouthopen": {
  "jawOpen": 1.0
 },
 "eyesclosed": {
  "eyeBlinkLeft": 0.5,
  "eyeBlinkRight": 0.5
 }
};
export const VISEMES: Readonly<Record<string, Readonly<Record<string, number>>>> = {
 "aa": {
  "jawOpen": 1.4,
  "mouthFunnel": -0.7,
  "mouthPucker": -0.7
 },
 "a": {
  "jawOpen": 1.4,
  "mouthFunnel": -0.7,
  "mouthPucker": -0.7
 },
 "ih": {
  "mouthStretchLeft": 0.6,
  "mouthStretchRight": 0.6
 },
 "i": {
  "mouthStretchLeft": 0.6,
  "mouthStretchRight": 0.6
 },
 "ou": {
  "mouthPucker": 1.0
 },
 "u": {
  "mouthPucker": 1.0
 },
 "oh": {
  "mouthFunnel": 1.0
 },
 "o": {
  "mouthFunnel": 1.0
 },
 "pp": {
  "mouthPressLeft": 0.5,
  "mouthPressRight": 0.5
 },
 "ff": {
  "mouthRollLower": 1.0
 },
 "blink": {
  "eyeBlinkLeft": 0.5,
  "eyeBlinkRight": 0.5
 },
 "blinkl": {
  "eyeBlinkLeft": 1.0
 },
 "blinkr": {
  "eyeBlinkRight": 1.0
 },
 "blinkleft": {
  "eyeBlinkLeft": 1.0
 },
 "blinkright": {
  "eyeBlinkRight": 1.0
 },
 "e": {
  "mouthUpperUpLeft": 0.4,
  "mouthUpperUpRight": 0.4,
  "mouthLowerDownLeft": 0.4,
  "mouthLowerDownRight": 0.4
 },
 "ee": {
  "mouthUpperUpLeft": 0.4,
  "mouthUpperUpRight": 0.4,
  "mouthLowerDownLeft": 0.4,
  "mouthLowerDownRight": 0.4
 },
 "dd": {
  "tongueTipUp": 0.8
 },
 "nn": {
  "tongueTipUp": 0.8
 },
 "kk": {
  "tongueBackUp": 0.8
 },
 "th": {
  "tongueOut": 1.2
 }
};
export const NODES: Readonly<Record<string, readonly string[]>> = {
 "head": [
  "head",
  "jbipchead",
  "mixamorighead",
  "bip01head",
  "headbone",
  "cchead",
  "ccbasehead"
 ],
 "eyeLeft": [
  "lefteye",
  "eyeleft",
  "eyel",
  "jadjlfaceeye",
  "mixamoriglefteye",
  "ccbaseleye",
  "leyeball"
 ],
 "eyeRight": [
  "righteye",
  "eyeright",
  "eyer",
  "jadjrfaceeye",
  "mixamorigrighteye",
  "ccbasereye",
  "reyeball"
 ]
};
export const EYE_DEGREES: Readonly<Record<string, number>> = {
 "up": 18.0,
 "down": 24.0,
 "in": 28.0,
 "out": 30.0
};
