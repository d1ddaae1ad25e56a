"""Lines of the log of a run, from its events."""

from bt_manip.runner import RunEvent


def log_line(event: RunEvent) -> tuple[str, str] | None:
    """Return the level and the text of an event for people; None for the others."""
    data = event.data
    if event.kind == "cycle":
        if data["status"] == "FAILURE":
            return "ERROR", f"cycle {data['cycle'] + 1} failed: {data['reason']}"
        done = "started" if data["status"] == "RUNNING" else "succeeded"
        return "INFO", f"cycle {data['cycle'] + 1} {done}"
    if event.kind == "status" and data["reason"]:
        return "WARNING", f"{data['path']}: {data['reason']}"
    if event.kind == "motion" and data["fault"]:
        return "WARNING", f"{data['robot']} stopped: {data['fault']}"
    if event.kind == "edit":
        if data["problems"]:
            return "ERROR", "; ".join(data["problems"])
        return "INFO", "the edited tree begins anew"
    if event.kind == "entity":
        return "INFO", f"{data['name']} {'added' if data['present'] else 'removed'}"
    if event.kind == "intervention" and data["kind"] == "override":
        return "WARNING", f"{data['path']}: its status was set to {data['status']}"
    if event.kind == "intervention" and (data["begins"] or data["target"] is None):
        return "WARNING", f"{data['body']} is {'pulled' if data['begins'] else 'let go'}"
    if event.kind == "controller":
        return "INFO", f"{data['robot']} is controlled by {data['controller']}"
    return None
