"""Ten lines: a sentence with direction in it, in a happy voice of the face, as a film and as a GLB.

python examples/ten_lines.py
"""

from pathlib import Path

import mien

folder = Path("out")
folder.mkdir(exist_ok=True)
line = mien.say('That is <HeadNod count="2"/> true. <WinkLeft/> I <emphasis>mean</emphasis> it.', emotion="happy:0.5")
mien.save(line, folder / "line.mp4", folder / "line.glb")
for word in line.utterance.words:
    jaw = line.channels.select(("jawOpen",)).values[
        line.rate.frames_covering(word.start) : line.rate.frames_covering(word.end)
    ]
    print(f"{word.start:6.3f} s  {word.label:8}  jaw at most {jaw.max(initial=0):.2f}")
