"""Ask the question `amplitude-share` at every door of the package in a folder: `python -m` with FOLDER, DATA and STUDY.

`test_new_question` has that package, and judges what is printed as JSON.
"""

import contextlib
import inspect
import io
import json
import sys
import threading
import time
from pathlib import Path
from typing import Any

import httpx
import uvicorn


def main() -> None:
    """Serve a store, and ask over HTTP, by the client and by the command."""
    folder, data, study = sys.argv[1], Path(sys.argv[2]), sys.argv[3]
    sys.path.insert(0, folder)
    import damperlab.service
    from damperlab.service.app import create_app
    from damperlab.service.cli.main import app as commands
    from damperlab.service.client import Client
    from damperlab.service.page.words import words_module
    from damperlab.service.settings import Settings
    from damperlab.service.work.kept import READS

    assert Path(damperlab.service.__file__).is_relative_to(folder), damperlab.service.__file__
    app = create_app(Settings(data_dir=data, warm=False))
    server = uvicorn.Server(uvicorn.Config(app, port=0, log_config=None))
    thread = threading.Thread(target=server.run)
    thread.start()
    while not server.started:
        time.sleep(0.02)
    url = f"http://127.0.0.1:{server.servers[0].sockets[0].getsockname()[1]}"
    address = f"{url}/api/v1/studies/{study}/amplitude-share"
    try:
        answer = httpx.get(address, params={"share": 0.25}, timeout=300)
        refused = httpx.get(address, params={"share": 2}, timeout=300)
        ask: Any = Client(url).study(study).amplitude_share  # type: ignore[attr-defined]
        dataset = ask(share=0.25)
        dataset.plot(data / "share.png")
    finally:
        server.should_exit = True
        thread.join()
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        commands(
            args=["share", study, "--share", "0.25", "--json", "--data-dir", str(data)], standalone_mode=False
        )
    told = {
        "http": answer.json(),
        "status": answer.status_code,
        "refused": refused.json(),
        "signature": str(inspect.signature(ask)),
        "help": ask.__doc__,
        "client": dataset["amplitude_ratio"].values.tolist(),
        "command": json.loads(printed.getvalue()),
        "document": app.openapi(),
        "words": words_module().decode(),
        "reads": READS.get("amplitude-share"),
    }
    print(json.dumps(told))


if __name__ == "__main__":
    main()
