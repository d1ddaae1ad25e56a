"""What a run leaves behind: its report, its trace, its digest.

`bt_manip.recording.report` and `bt_manip.recording.files` import nothing heavy; the other modules
look into the physics.
"""
