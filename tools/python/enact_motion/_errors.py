"""Exceptions of the package."""


class SceneError(ValueError):
    """A scene that is refused.

    Attributes: ``message``, what is wrong and what was expected; ``file``, the file or None; ``line`` and ``column`` in it,
    from 1.
    """

    def __init__(self, message, file=None, line=1, column=1):
        super().__init__(message, file, line, column)
        self.message = message
        self.file = file
        self.line = line
        self.column = column

    def __str__(self):
        return f"{self.file or 'scene'}:{self.line}:{self.column}: {self.message}"


class TakeError(ValueError):
    """A take that cannot be read, or of which no estimate is possible.

    Attributes: ``message``; ``diagnoses``, likely mistakes in what is said of the performance, a sentence each.
    """

    def __init__(self, message, diagnoses=()):
        super().__init__(message, tuple(diagnoses))
        self.message = message
        self.diagnoses = tuple(diagnoses)

    def __str__(self):
        return self.message
