"""What a job leaves in its folder."""

from types import SimpleNamespace

from roadmend.safe import driving
from roadmend.safe.driving import CrashTestJob, Task, digest_of, do

from .crashes import HEAD_ON, role


def test_pictures_stay_in_their_folder_whatever_a_policy_is_called(tmp_path, monkeypatch):
    monkeypatch.setattr(driving, "run_trial", lambda *_: SimpleNamespace(summary=None, is_physical=True))

    def draw(_scenario, _trial, file):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(b"picture")

    def drive(policy):
        return do(CrashTestJob(Task.TEST, role(HEAD_ON), policy, 0, 0, 0, tmp_path / "out", draw))

    results = [drive(policy) for policy in ("modular", "../../one/m.safetensors", "../../two/m.safetensors")]
    assert [result.note for result in results] == ["", "", ""]
    assert results[0].picture == "pictures/sample-v1-0-modular.png"
    found = sorted(path.name for path in (tmp_path / "out" / "pictures").iterdir())
    assert found == sorted(result.picture.removeprefix("pictures/") for result in results)
    assert len({*found}) == 3
    assert {path.name for path in tmp_path.iterdir()} == {"out"}
    for file, digest in results[1].digests.items():
        assert digest_of(tmp_path / "out" / file) == digest
    assert {*results[1].digests} == {results[1].scenario, results[1].picture}
    assert digest_of(tmp_path / "gone") == ""
