// Written by tools/viewer_files.py from mien.core.channels and src/mien/assets/rigs. Do not edit.
export interface Convention {
  title: string; kind: string; needs: number; targets: Readonly<Record<string, Readonly<Record<string, number>>>>;
}
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
export const CONVENTIONS: readonly Convention[] = [
 {
  "title": "ARKit",
  "kind": "shapes",
  "needs": 1,
  "targets": {
   "browinnerupleft": {
    "browInnerUp": 1.0,
    "browInnerUpLeft": 1.0
   },
   "browinnerupright": {
    "browInnerUp": 1.0,
    "browInnerUpRight": 1.0
   },
   "cheekpuffleft": {
    "cheekPuff": 1.0
   },
   "cheekpuffright": {
    "cheekPuff": 1.0
   },
   "mouthrolllowerleft": {
    "mouthRollLower": 1.0
   },
   "mouthrolllowerright": {
    "mouthRollLower": 1.0
   },
   "mouthrollupperleft": {
    "mouthRollUpper": 1.0
   },
   "mouthrollupperright": {
    "mouthRollUpper": 1.0
   },
   "mouthfunnelleft": {
    "mouthFunnel": 1.0
   },
   "mouthfunnelright": {
    "mouthFunnel": 1.0
   },
   "mouthpuckerleft": {
    "mouthPucker": 1.0
   },
   "mouthpuckerright": {
    "mouthPucker": 1.0
   },
   "mouthfunnellower": {
    "mouthFunnel": 1.0
   },
   "mouthfunnelupper": {
    "mouthFunnel": 1.0
   },
   "mouthpuckerlower": {
    "mouthPucker": 1.0
   },
   "mouthpuckerupper": {
    "mouthPucker": 1.0
   },
   "mouthcloseleft": {
    "mouthClose": 1.0
   },
   "mouthcloseright": {
    "mouthClose": 1.0
   },
   "mouthclosed": {
    "mouthClose": 1.0
   },
   "mouthshruglowerleft": {
    "mouthShrugLower": 1.0
   },
   "mouthshruglowerright": {
    "mouthShrugLower": 1.0
   },
   "mouthshrugupperleft": {
    "mouthShrugUpper": 1.0
   },
   "mouthshrugupperright": {
    "mouthShrugUpper": 1.0
   },
   "nostrildilatorleft": {
    "noseFlareLeft": 1.0
   },
   "nostrildilatorright": {
    "noseFlareRight": 1.0
   },
   "nostrilcompressorleft": {
    "noseCompressLeft": 1.0
   },
   "nostrilcompressorright": {
    "noseCompressRight": 1.0
   },
   "browdown": {
    "browDownLeft": 0.5,
    "browDownRight": 0.5
   },
   "browouterup": {
    "browOuterUpLeft": 0.5,
    "browOuterUpRight": 0.5
   },
   "eyeblink": {
    "eyeBlinkLeft": 0.5,
    "eyeBlinkRight": 0.5
   },
   "eyesquint": {
    "eyeSquintLeft": 0.5,
    "eyeSquintRight": 0.5
   },
   "eyewide": {
    "eyeWideLeft": 0.5,
    "eyeWideRight": 0.5
   },
   "eyelookup": {
    "eyeLookUpLeft": 0.5,
    "eyeLookUpRight": 0.5
   },
   "eyelookdown": {
    "eyeLookDownLeft": 0.5,
    "eyeLookDownRight": 0.5
   },
   "cheeksquint": {
    "cheekSquintLeft": 0.5,
    "cheekSquintRight": 0.5
   },
   "nosesneer": {
    "noseSneerLeft": 0.5,
    "noseSneerRight": 0.5
   },
   "mouthsmile": {
    "mouthSmileLeft": 0.5,
    "mouthSmileRight": 0.5
   },
   "mouthfrown": {
    "mouthFrownLeft": 0.5,
    "mouthFrownRight": 0.5
   },
   "mouthdimple": {
    "mouthDimpleLeft": 0.5,
    "mouthDimpleRight": 0.5
   },
   "mouthstretch": {
    "mouthStretchLeft": 0.5,
    "mouthStretchRight": 0.5
   },
   "mouthpress": {
    "mouthPressLeft": 0.5,
    "mouthPressRight": 0.5
   },
   "mouthlowerdown": {
    "mouthLowerDownLeft": 0.5,
    "mouthLowerDownRight": 0.5
   },
   "mouthupperup": {
    "mouthUpperUpLeft": 0.5,
    "mouthUpperUpRight": 0.5
   },
   "mouthroll": {
    "mouthRollLower": 0.5,
    "mouthRollUpper": 0.5
   },
   "mouthshrug": {
    "mouthShrugLower": 0.5,
    "mouthShrugUpper": 0.5
   },
   "eyeblinkleft": {
    "eyeBlinkLeft": 1.0
   },
   "eyelookdownleft": {
    "eyeLookDownLeft": 1.0
   },
   "eyelookinleft": {
    "eyeLookInLeft": 1.0
   },
   "eyelookoutleft": {
    "eyeLookOutLeft": 1.0
   },
   "eyelookupleft": {
    "eyeLookUpLeft": 1.0
   },
   "eyesquintleft": {
    "eyeSquintLeft": 1.0
   },
   "eyewideleft": {
    "eyeWideLeft": 1.0
   },
   "eyeblinkright": {
    "eyeBlinkRight": 1.0
   },
   "eyelookdownright": {
    "eyeLookDownRight": 1.0
   },
   "eyelookinright": {
    "eyeLookInRight": 1.0
   },
   "eyelookoutright": {
    "eyeLookOutRight": 1.0
   },
   "eyelookupright": {
    "eyeLookUpRight": 1.0
   },
   "eyesquintright": {
    "eyeSquintRight": 1.0
   },
   "eyewideright": {
    "eyeWideRight": 1.0
   },
   "jawforward": {
    "jawForward": 1.0
   },
   "jawright": {
    "jawRight": 1.0
   },
   "jawleft": {
    "jawLeft": 1.0
   },
   "jawopen": {
    "jawOpen": 1.0
   },
   "mouthclose": {
    "mouthClose": 1.0
   },
   "mouthfunnel": {
    "mouthFunnel": 1.0
   },
   "mouthpucker": {
    "mouthPucker": 1.0
   },
   "mouthright": {
    "mouthRight": 1.0
   },
   "mouthleft": {
    "mouthLeft": 1.0
   },
   "mouthsmileleft": {
    "mouthSmileLeft": 1.0
   },
   "mouthsmileright": {
    "mouthSmileRight": 1.0
   },
   "mouthfrownleft": {
    "mouthFrownLeft": 1.0
   },
   "mouthfrownright": {
    "mouthFrownRight": 1.0
   },
   "mouthdimpleleft": {
    "mouthDimpleLeft": 1.0
   },
   "mouthdimpleright": {
    "mouthDimpleRight": 1.0
   },
   "mouthstretchleft": {
    "mouthStretchLeft": 1.0
   },
   "mouthstretchright": {
    "mouthStretchRight": 1.0
   },
   "mouthrolllower": {
    "mouthRollLower": 1.0
   },
   "mouthrollupper": {
    "mouthRollUpper": 1.0
   },
   "mouthshruglower": {
    "mouthShrugLower": 1.0
   },
   "mouthshrugupper": {
    "mouthShrugUpper": 1.0
   },
   "mouthpressleft": {
    "mouthPressLeft": 1.0
   },
   "mouthpressright": {
    "mouthPressRight": 1.0
   },
   "mouthlowerdownleft": {
    "mouthLowerDownLeft": 1.0
   },
   "mouthlowerdownright": {
    "mouthLowerDownRight": 1.0
   },
   "mouthupperupleft": {
    "mouthUpperUpLeft": 1.0
   },
   "mouthupperupright": {
    "mouthUpperUpRight": 1.0
   },
   "browdownleft": {
    "browDownLeft": 1.0
   },
   "browdownright": {
    "browDownRight": 1.0
   },
   "browinnerup": {
    "browInnerUp": 1.0
   },
   "browouterupleft": {
    "browOuterUpLeft": 1.0
   },
   "browouterupright": {
    "browOuterUpRight": 1.0
   },
   "cheekpuff": {
    "cheekPuff": 1.0
   },
   "cheeksquintleft": {
    "cheekSquintLeft": 1.0
   },
   "cheeksquintright": {
    "cheekSquintRight": 1.0
   },
   "nosesneerleft": {
    "noseSneerLeft": 1.0
   },
   "nosesneerright": {
    "noseSneerRight": 1.0
   },
   "tongueout": {
    "tongueOut": 1.0
   },
   "tonguetipup": {
    "tongueTipUp": 1.0
   },
   "tonguebackup": {
    "tongueBackUp": 1.0
   },
   "tonguebladeup": {
    "tongueBladeUp": 1.0
   },
   "tonguecurl": {
    "tongueCurl": 1.0
   },
   "noseflareleft": {
    "noseFlareLeft": 1.0
   },
   "noseflareright": {
    "noseFlareRight": 1.0
   },
   "nosecompressleft": {
    "noseCompressLeft": 1.0
   },
   "nosecompressright": {
    "noseCompressRight": 1.0
   },
   "nasolabialdeepenleft": {
    "nasolabialDeepenLeft": 1.0
   },
   "nasolabialdeepenright": {
    "nasolabialDeepenRight": 1.0
   },
   "mouthsharppullleft": {
    "mouthSharpPullLeft": 1.0
   },
   "mouthsharppullright": {
    "mouthSharpPullRight": 1.0
   },
   "mouthtightenleft": {
    "mouthTightenLeft": 1.0
   },
   "mouthtightenright": {
    "mouthTightenRight": 1.0
   }
  }
 },
 {
  "title": "Oculus visemes",
  "kind": "visemes",
  "needs": 3,
  "targets": {
   "visemepp": {
    "mouthPressLeft": 1.2,
    "mouthPressRight": 1.2,
    "mouthClose": 1.5
   },
   "visemeff": {
    "mouthRollLower": 1.1
   },
   "visemeth": {
    "tongueOut": 1.4
   },
   "visemedd": {
    "tongueTipUp": 0.8,
    "mouthFunnel": -0.8
   },
   "visemekk": {
    "tongueBackUp": 0.8
   },
   "visemech": {
    "mouthFunnel": 0.6,
    "mouthPucker": 0.3,
    "tongueTipUp": 0.5,
    "jawOpen": -1.0
   },
   "visemess": {
    "mouthLowerDownLeft": 0.6,
    "mouthLowerDownRight": 0.6,
    "jawOpen": -1.5,
    "mouthFunnel": -1.0
   },
   "visemenn": {
    "tongueTipUp": 0.3,
    "mouthFunnel": -0.3
   },
   "visemerr": {
    "mouthFunnel": 0.5,
    "tongueTipUp": 0.5,
    "mouthLowerDownLeft": -1.0,
    "mouthLowerDownRight": -1.0
   },
   "visemeaa": {
    "jawOpen": 1.4,
    "mouthFunnel": -0.7,
    "mouthPucker": -0.7
   },
   "visemee": {
    "mouthUpperUpLeft": 0.5,
    "mouthUpperUpRight": 0.5,
    "mouthLowerDownLeft": 0.5,
    "mouthLowerDownRight": 0.5
   },
   "visemei": {
    "mouthStretchLeft": 0.8,
    "mouthStretchRight": 0.8,
    "mouthSmileLeft": 0.15,
    "mouthSmileRight": 0.15
   },
   "visemeih": {
    "mouthStretchLeft": 0.8,
    "mouthStretchRight": 0.8,
    "mouthSmileLeft": 0.15,
    "mouthSmileRight": 0.15
   },
   "visemeo": {
    "mouthFunnel": 1.0
   },
   "visemeoh": {
    "mouthFunnel": 1.0
   },
   "visemeu": {
    "mouthPucker": 1.0
   },
   "visemeou": {
    "mouthPucker": 1.0
   },
   "vpp": {
    "mouthPressLeft": 1.2,
    "mouthPressRight": 1.2,
    "mouthClose": 1.5
   },
   "vff": {
    "mouthRollLower": 1.1
   },
   "vth": {
    "tongueOut": 1.4
   },
   "vdd": {
    "tongueTipUp": 0.8,
    "mouthFunnel": -0.8
   },
   "vkk": {
    "tongueBackUp": 0.8
   },
   "vch": {
    "mouthFunnel": 0.6,
    "mouthPucker": 0.3,
    "tongueTipUp": 0.5,
    "jawOpen": -1.0
   },
   "vss": {
    "mouthLowerDownLeft": 0.6,
    "mouthLowerDownRight": 0.6,
    "jawOpen": -1.5,
    "mouthFunnel": -1.0
   },
   "vnn": {
    "tongueTipUp": 0.3,
    "mouthFunnel": -0.3
   },
   "vrr": {
    "mouthFunnel": 0.5,
    "tongueTipUp": 0.5,
    "mouthLowerDownLeft": -1.0,
    "mouthLowerDownRight": -1.0
   },
   "vaa": {
    "jawOpen": 1.4,
    "mouthFunnel": -0.7,
    "mouthPucker": -0.7
   },
   "ve": {
    "mouthUpperUpLeft": 0.5,
    "mouthUpperUpRight": 0.5,
    "mouthLowerDownLeft": 0.5,
    "mouthLowerDownRight": 0.5
   },
   "vi": {
    "mouthStretchLeft": 0.8,
    "mouthStretchRight": 0.8,
    "mouthSmileLeft": 0.15,
    "mouthSmileRight": 0.15
   },
   "vih": {
    "mouthStretchLeft": 0.8,
    "mouthStretchRight": 0.8,
    "mouthSmileLeft": 0.15,
    "mouthSmileRight": 0.15
   },
   "vo": {
    "mouthFunnel": 1.0
   },
   "voh": {
    "mouthFunnel": 1.0
   },
   "vu": {
    "mouthPucker": 1.0
   },
   "vou": {
    "mouthPucker": 1.0
   },
   "vrcvpp": {
    "mouthPressLeft": 1.2,
    "mouthPressRight": 1.2,
    "mouthClose": 1.5
   },
   "vrcvff": {
    "mouthRollLower": 1.1
   },
   "vrcvth": {
    "tongueOut": 1.4
   },
   "vrcvdd": {
    "tongueTipUp": 0.8,
    "mouthFunnel": -0.8
   },
   "vrcvkk": {
    "tongueBackUp": 0.8
   },
   "vrcvch": {
    "mouthFunnel": 0.6,
    "mouthPucker": 0.3,
    "tongueTipUp": 0.5,
    "jawOpen": -1.0
   },
   "vrcvss": {
    "mouthLowerDownLeft": 0.6,
    "mouthLowerDownRight": 0.6,
    "jawOpen": -1.5,
    "mouthFunnel": -1.0
   },
   "vrcvnn": {
    "tongueTipUp": 0.3,
    "mouthFunnel": -0.3
   },
   "vrcvrr": {
    "mouthFunnel": 0.5,
    "tongueTipUp": 0.5,
    "mouthLowerDownLeft": -1.0,
    "mouthLowerDownRight": -1.0
   },
   "vrcvaa": {
    "jawOpen": 1.4,
    "mouthFunnel": -0.7,
    "mouthPucker": -0.7
   },
   "vrcve": {
    "mouthUpperUpLeft": 0.5,
    "mouthUpperUpRight": 0.5,
    "mouthLowerDownLeft": 0.5,
    "mouthLowerDownRight": 0.5
   },
   "vrcvi": {
    "mouthStretchLeft": 0.8,
    "mouthStretchRight": 0.8,
    "mouthSmileLeft": 0.15,
    "mouthSmileRight": 0.15
   },
   "vrcvih": {
    "mouthStretchLeft": 0.8,
    "mouthStretchRight": 0.8,
    "mouthSmileLeft": 0.15,
    "mouthSmileRight": 0.15
   },
   "vrcvo": {
    "mouthFunnel": 1.0
   },
   "vrcvoh": {
    "mouthFunnel": 1.0
   },
   "vrcvu": {
    "mouthPucker": 1.0
   },
   "vrcvou": {
    "mouthPucker": 1.0
   },
   "pp": {
    "mouthPressLeft": 1.2,
    "mouthPressRight": 1.2,
    "mouthClose": 1.5
   },
   "ff": {
    "mouthRollLower": 1.1
   },
   "th": {
    "tongueOut": 1.4
   },
   "dd": {
    "tongueTipUp": 0.8,
    "mouthFunnel": -0.8
   },
   "kk": {
    "tongueBackUp": 0.8
   },
   "ch": {
    "mouthFunnel": 0.6,
    "mouthPucker": 0.3,
    "tongueTipUp": 0.5,
    "jawOpen": -1.0
   },
   "ss": {
    "mouthLowerDownLeft": 0.6,
    "mouthLowerDownRight": 0.6,
    "jawOpen": -1.5,
    "mouthFunnel": -1.0
   },
   "nn": {
    "tongueTipUp": 0.3,
    "mouthFunnel": -0.3
   },
   "rr": {
    "mouthFunnel": 0.5,
    "tongueTipUp": 0.5,
    "mouthLowerDownLeft": -1.0,
    "mouthLowerDownRight": -1.0
   },
   "aa": {
    "jawOpen": 1.4,
    "mouthFunnel": -0.7,
    "mouthPucker": -0.7
   },
   "ih": {
    "mouthStretchLeft": 0.8,
    "mouthStretchRight": 0.8,
    "mouthSmileLeft": 0.15,
    "mouthSmileRight": 0.15
   },
   "oh": {
    "mouthFunnel": 1.0
   },
   "ou": {
    "mouthPucker": 1.0
   }
  }
 },
 {
  "title": "VRM and five vowels",
  "kind": "visemes",
  "needs": 2,
  "targets": {
   "a": {
    "jawOpen": 1.4,
    "mouthFunnel": -0.7,
    "mouthPucker": -0.7
   },
   "i": {
    "mouthStretchLeft": 0.8,
    "mouthStretchRight": 0.8,
    "mouthSmileLeft": 0.15,
    "mouthSmileRight": 0.15
   },
   "u": {
    "mouthPucker": 1.0
   },
   "e": {
    "mouthUpperUpLeft": 0.5,
    "mouthUpperUpRight": 0.5,
    "mouthLowerDownLeft": 0.5,
    "mouthLowerDownRight": 0.5
   },
   "o": {
    "mouthFunnel": 1.0
   },
   "aa": {
    "jawOpen": 1.4,
    "mouthFunnel": -0.7,
    "mouthPucker": -0.7
   },
   "ah": {
    "jawOpen": 1.4,
    "mouthFunnel": -0.7,
    "mouthPucker": -0.7
   },
   "ih": {
    "mouthStretchLeft": 0.8,
    "mouthStretchRight": 0.8,
    "mouthSmileLeft": 0.15,
    "mouthSmileRight": 0.15
   },
   "ou": {
    "mouthPucker": 1.0
   },
   "oo": {
    "mouthPucker": 1.0
   },
   "ee": {
    "mouthUpperUpLeft": 0.5,
    "mouthUpperUpRight": 0.5,
    "mouthLowerDownLeft": 0.5,
    "mouthLowerDownRight": 0.5
   },
   "eh": {
    "mouthUpperUpLeft": 0.5,
    "mouthUpperUpRight": 0.5,
    "mouthLowerDownLeft": 0.5,
    "mouthLowerDownRight": 0.5
   },
   "oh": {
    "mouthFunnel": 1.0
   },
   "あ": {
    "jawOpen": 1.4,
    "mouthFunnel": -0.7,
    "mouthPucker": -0.7
   },
   "い": {
    "mouthStretchLeft": 0.8,
    "mouthStretchRight": 0.8,
    "mouthSmileLeft": 0.15,
    "mouthSmileRight": 0.15
   },
   "う": {
    "mouthPucker": 1.0
   },
   "え": {
    "mouthUpperUpLeft": 0.5,
    "mouthUpperUpRight": 0.5,
    "mouthLowerDownLeft": 0.5,
    "mouthLowerDownRight": 0.5
   },
   "お": {
    "mouthFunnel": 1.0
   },
   "fclmtha": {
    "jawOpen": 1.4,
    "mouthFunnel": -0.7,
    "mouthPucker": -0.7
   },
   "fclmthi": {
    "mouthStretchLeft": 0.8,
    "mouthStretchRight": 0.8,
    "mouthSmileLeft": 0.15,
    "mouthSmileRight": 0.15
   },
   "fclmthu": {
    "mouthPucker": 1.0
   },
   "fclmthe": {
    "mouthUpperUpLeft": 0.5,
    "mouthUpperUpRight": 0.5,
    "mouthLowerDownLeft": 0.5,
    "mouthLowerDownRight": 0.5
   },
   "fclmtho": {
    "mouthFunnel": 1.0
   },
   "moutha": {
    "jawOpen": 1.4,
    "mouthFunnel": -0.7,
    "mouthPucker": -0.7
   },
   "mouthi": {
    "mouthStretchLeft": 0.8,
    "mouthStretchRight": 0.8,
    "mouthSmileLeft": 0.15,
    "mouthSmileRight": 0.15
   },
   "mouthu": {
    "mouthPucker": 1.0
   },
   "mouthe": {
    "mouthUpperUpLeft": 0.5,
    "mouthUpperUpRight": 0.5,
    "mouthLowerDownLeft": 0.5,
    "mouthLowerDownRight": 0.5
   },
   "moutho": {
    "mouthFunnel": 1.0
   },
   "vowela": {
    "jawOpen": 1.4,
    "mouthFunnel": -0.7,
    "mouthPucker": -0.7
   },
   "voweli": {
    "mouthStretchLeft": 0.8,
    "mouthStretchRight": 0.8,
    "mouthSmileLeft": 0.15,
    "mouthSmileRight": 0.15
   },
   "vowelu": {
    "mouthPucker": 1.0
   },
   "vowele": {
    "mouthUpperUpLeft": 0.5,
    "mouthUpperUpRight": 0.5,
    "mouthLowerDownLeft": 0.5,
    "mouthLowerDownRight": 0.5
   },
   "vowelo": {
    "mouthFunnel": 1.0
   },
   "lipa": {
    "jawOpen": 1.4,
    "mouthFunnel": -0.7,
    "mouthPucker": -0.7
   },
   "lipi": {
    "mouthStretchLeft": 0.8,
    "mouthStretchRight": 0.8,
    "mouthSmileLeft": 0.15,
    "mouthSmileRight": 0.15
   },
   "lipu": {
    "mouthPucker": 1.0
   },
   "lipe": {
    "mouthUpperUpLeft": 0.5,
    "mouthUpperUpRight": 0.5,
    "mouthLowerDownLeft": 0.5,
    "mouthLowerDownRight": 0.5
   },
   "lipo": {
    "mouthFunnel": 1.0
   },
   "ma": {
    "jawOpen": 1.4,
    "mouthFunnel": -0.7,
    "mouthPucker": -0.7
   },
   "mi": {
    "mouthStretchLeft": 0.8,
    "mouthStretchRight": 0.8,
    "mouthSmileLeft": 0.15,
    "mouthSmileRight": 0.15
   },
   "mu": {
    "mouthPucker": 1.0
   },
   "me": {
    "mouthUpperUpLeft": 0.5,
    "mouthUpperUpRight": 0.5,
    "mouthLowerDownLeft": 0.5,
    "mouthLowerDownRight": 0.5
   },
   "mo": {
    "mouthFunnel": 1.0
   },
   "mtha": {
    "jawOpen": 1.4,
    "mouthFunnel": -0.7,
    "mouthPucker": -0.7
   },
   "mthi": {
    "mouthStretchLeft": 0.8,
    "mouthStretchRight": 0.8,
    "mouthSmileLeft": 0.15,
    "mouthSmileRight": 0.15
   },
   "mthu": {
    "mouthPucker": 1.0
   },
   "mthe": {
    "mouthUpperUpLeft": 0.5,
    "mouthUpperUpRight": 0.5,
    "mouthLowerDownLeft": 0.5,
    "mouthLowerDownRight": 0.5
   },
   "mtho": {
    "mouthFunnel": 1.0
   },
   "mouthshapea": {
    "jawOpen": 1.4,
    "mouthFunnel": -0.7,
    "mouthPucker": -0.7
   },
   "mouthshapei": {
    "mouthStretchLeft": 0.8,
    "mouthStretchRight": 0.8,
    "mouthSmileLeft": 0.15,
    "mouthSmileRight": 0.15
   },
   "mouthshapeu": {
    "mouthPucker": 1.0
   },
   "mouthshapee": {
    "mouthUpperUpLeft": 0.5,
    "mouthUpperUpRight": 0.5,
    "mouthLowerDownLeft": 0.5,
    "mouthLowerDownRight": 0.5
   },
   "mouthshapeo": {
    "mouthFunnel": 1.0
   }
  }
 },
 {
  "title": "VRoid, VRM lids and MMD",
  "kind": "shapes",
  "needs": 1,
  "targets": {
   "blinkleft": {
    "eyeBlinkLeft": 1.0
   },
   "blinkright": {
    "eyeBlinkRight": 1.0
   },
   "fcleyecloseleft": {
    "eyeBlinkLeft": 1.0
   },
   "fcleyecloseright": {
    "eyeBlinkRight": 1.0
   },
   "vrcblinkleft": {
    "eyeBlinkLeft": 1.0
   },
   "vrcblinkright": {
    "eyeBlinkRight": 1.0
   },
   "fclbrwangry": {
    "browDownLeft": 0.5,
    "browDownRight": 0.5
   },
   "fclbrwsorrow": {
    "browInnerUp": 0.8
   },
   "fclbrwsurprised": {
    "browOuterUpLeft": 0.5,
    "browOuterUpRight": 0.5
   },
   "fcleyespread": {
    "eyeWideLeft": 0.5,
    "eyeWideRight": 0.5
   },
   "fclmthfun": {
    "mouthSmileLeft": 0.45,
    "mouthSmileRight": 0.45
   },
   "fclmthdown": {
    "mouthFrownLeft": 0.5,
    "mouthFrownRight": 0.5
   },
   "怒り": {
    "browDownLeft": 0.5,
    "browDownRight": 0.5
   },
   "困る": {
    "browInnerUp": 0.8
   },
   "びっくり": {
    "eyeWideLeft": 0.5,
    "eyeWideRight": 0.5
   },
   "にやり": {
    "mouthSmileLeft": 0.45,
    "mouthSmileRight": 0.45
   },
   "口角上げ": {
    "mouthSmileLeft": 0.5,
    "mouthSmileRight": 0.5
   },
   "口角下げ": {
    "mouthFrownLeft": 0.5,
    "mouthFrownRight": 0.5
   },
   "ウィンク": {
    "eyeBlinkLeft": 1.0
   },
   "ウィンク右": {
    "eyeBlinkRight": 1.0
   },
   "fcleyeclose": {
    "eyeBlinkLeft": 0.5,
    "eyeBlinkRight": 0.5
   },
   "まばたき": {
    "eyeBlinkLeft": 0.5,
    "eyeBlinkRight": 0.5
   },
   "blink": {
    "eyeBlinkLeft": 0.5,
    "eyeBlinkRight": 0.5
   },
   "vrcblink": {
    "eyeBlinkLeft": 0.5,
    "eyeBlinkRight": 0.5
   },
   "fclbrwfun": {
    "browOuterUpLeft": 0.3,
    "browOuterUpRight": 0.3
   },
   "fclmthup": {
    "mouthSmileLeft": 0.5,
    "mouthSmileRight": 0.5
   }
  }
 }
];
export const NODES: Readonly<Record<string, readonly string[]>> = {
 "head": [
  "head",
  "jbipchead",
  "mixamorighead",
  "bip01head",
  "bip1head",
  "bip001head",
  "headx",
  "cheadjnt",
  "headctrl",
  "orghead",
  "headbone",
  "cchead",
  "ccbasehead",
  "defhead",
  "headjoint",
  "headjnt",
  "jnthead",
  "bhead",
  "bonehead",
  "charahead",
  "armaturehead",
  "genesis8femalehead",
  "headm",
  "頭",
  "spine6",
  "defspine6",
  "grptransform",
  "headroot",
  "headgrp",
  "grphead",
  "facejoint"
 ],
 "eyeLeft": [
  "lefteye",
  "eyeleft",
  "eyel",
  "jadjlfaceeye",
  "mixamoriglefteye",
  "ccbaseleye",
  "leyeball",
  "leye",
  "eyeballleft",
  "eyeballl",
  "deflefteye",
  "jnteyeleft",
  "facialeyel",
  "lefteyeball",
  "eyejntl",
  "mcheyel",
  "左目",
  "deleyel",
  "lefteyejoint",
  "grpeyeleft",
  "defeyel",
  "facialleye",
  "ceyel",
  "eyelx",
  "eyelefta",
  "orgeyel",
  "eyeljnt",
  "leyejnt"
 ],
 "eyeRight": [
  "righteye",
  "eyeright",
  "eyer",
  "jadjrfaceeye",
  "mixamorigrighteye",
  "ccbasereye",
  "reyeball",
  "reye",
  "eyeballright",
  "eyeballr",
  "defrighteye",
  "jnteyeright",
  "facialeyer",
  "righteyeball",
  "eyejntr",
  "mcheyer",
  "右目",
  "deleyer",
  "righteyejoint",
  "grpeyeright",
  "defeyer",
  "facialreye",
  "ceyer",
  "eyerx",
  "eyerighta",
  "orgeyer",
  "eyerjnt",
  "reyejnt"
 ],
 "neck": [
  "neck",
  "jbipcneck",
  "mixamorigneck",
  "neck01",
  "neck1",
  "neckx",
  "bip01neck",
  "bip001neck",
  "ccbasenecktwist01",
  "necktwist01",
  "necklower",
  "neckjnt",
  "jntneck",
  "defneck",
  "orgneck",
  "neckjoint",
  "cneckjnt",
  "bneck",
  "首"
 ],
 "jaw": [
  "jaw",
  "jbipcjaw",
  "mixamorigjaw",
  "lowerjaw",
  "jawbone",
  "jawroot",
  "ccbasejawroot",
  "facialcjaw",
  "cjaw",
  "jawjnt",
  "jntjaw",
  "cjawbonex",
  "defjaw",
  "jawmaster",
  "mandible",
  "jawlower",
  "bip01jaw",
  "bip001jaw",
  "headjaw",
  "bjaw",
  "bonejaw",
  "jawjoint",
  "あご",
  "顎",
  "下顎"
 ],
 "armLeft": [
  "jbiplupperarm",
  "mixamorigleftarm",
  "leftarm",
  "leftupperarm",
  "upperarml",
  "lupperarm",
  "ccbaselupperarm",
  "lshldrbend",
  "lupperarm1",
  "bip01lupperarm",
  "bip001lupperarm",
  "upperarm1l",
  "defupperarml",
  "carmstretchl",
  "armstretchl",
  "左腕",
  "arml",
  "upperarmleft"
 ],
 "armRight": [
  "jbiprupperarm",
  "mixamorigrightarm",
  "rightarm",
  "rightupperarm",
  "upperarmr",
  "rupperarm",
  "ccbaserupperarm",
  "rshldrbend",
  "rupperarm1",
  "bip01rupperarm",
  "bip001rupperarm",
  "upperarm1r",
  "defupperarmr",
  "carmstretchr",
  "armstretchr",
  "右腕",
  "armr",
  "upperarmright"
 ]
};
export const EYE_DEGREES: Readonly<Record<string, number>> = {
 "up": 18.0,
 "down": 24.0,
 "in": 28.0,
 "out": 30.0
};
