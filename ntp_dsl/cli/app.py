"""The command line: the exit status and the sentence for whatever comes of a command."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Sequence

from ntp_dsl.cli import extras
from ntp_dsl.cli.groups import command_name, invoke
from ntp_dsl.common.text import printable
from ntp_dsl.language.diagnostics.diagnostics import NtpError, SourceError, TaskFailed

NO, MISUSE, FAULT, INTERRUPTED, UNREAD = 1, 2, 70, 130, 141
INTERRUPTION = "interrupted; all files that were written are complete"
DEBUG = "NTP_DEBUG"  # in the environment: unforeseen errors show their traceback
MAX_REASON = 300  # [characters] of an unforeseen error


def run(words: Sequence[str]) -> int:
    """Run one command line and return its exit status. Whatever goes wrong is reported in a sentence."""
    try:
        return invoke(words)
    except TaskFailed as error:
        return _report(error, NO)
    except SourceError as error:
        return _report_diagnostics(error)
    except NtpError as error:
        return _report(error, MISUSE)
    except BrokenPipeError:
        return UNREAD  # whatever read the output, such as `head`, has seen enough
    except ChildProcessError as error:
        return _report(error, MISUSE)
    except OSError as error:
        return _report(f"{error.filename or 'a file or standard output'}: {error.strerror or error}", MISUSE)
    except KeyboardInterrupt:
        return _report(INTERRUPTION, INTERRUPTED)
    except Exception as error:
        return _report_unforeseen(error, command_name(words))


def _report(sentence: object, status: int) -> int:
    print("\n".join(map(printable, str(sentence).split("\n"))), file=sys.stderr)
    return status


def _report_diagnostics(error: SourceError) -> int:
    """Report all errors of a library that a command needs, as `ntp check` does."""
    from ntp_dsl.cli.report import print_diagnostics, summary

    print_diagnostics(error.diagnostics, error.sources, sys.stderr)
    return _report(summary(error.diagnostics), MISUSE)


def _report_unforeseen(error: Exception, command: str) -> int:
    """Report a missing extra, an interruption that a library turned into an error, or a fault of ours."""
    if isinstance(error, ModuleNotFoundError) and (sentence := extras.missing(command, error.name)):
        return _report(sentence, MISUSE)
    if _is_interruption(error):
        return _report(INTERRUPTION, INTERRUPTED)
    if os.environ.get(DEBUG):
        traceback.print_exception(error)
    reason = f"{type(error).__name__}: {error}".rstrip(": ").split("\n")[0][:MAX_REASON]
    advice = f"please report this, with the traceback that {DEBUG}=1 {command} ... shows"
    return _report(f"{command} failed for a reason that it should handle: {reason}\n{advice}", FAULT)


def _is_interruption(error: BaseException | None) -> bool:
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None
