"""Takes the frames of `mien perform --connect 7005` and moves something with them: it prints how far the jaw opens.

    python examples/frames_listener.py 7005 &
    echo 'That is <HeadNod/> true.' | mien interpret | mien speak | mien translate | mien perform --connect 7005

Needs nothing but Python; in another language it is the same few lines. Lines and answers: docs/modules.md.
"""

import json
import socket
import sys


def main(port: int) -> None:
    """Wait for one sender, show all its utterances, and say so after each."""
    with socket.create_server(("127.0.0.1", port)) as server:
        connection, _ = server.accept()
        with connection, connection.makefile("r", encoding="utf-8") as lines:
            for line in lines:
                if line.strip() == "<end/>":
                    connection.sendall(b"<end/>\n")
                    return
                identity, header = line.split(" ", 1)
                about = json.loads(header)
                jaw = about["channels"].index("jawOpen")
                for _ in range(about["frames"]):
                    frame = json.loads(next(lines))
                    print(f"{frame['time']:7.3f} s  {'#' * round(60 * frame['values'][jaw])}")
                assert json.loads(next(lines))["end"] == about["utterance"]
                connection.sendall(f'<done id="{identity}"/>\n'.encode())


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 7005)
