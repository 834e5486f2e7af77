"""The flight recorder: what the cycle takes in and gives out, from its start on, and how that is kept.

others ─▶ shared memory ─▶ border ─▶ memory of the cycle ─▶ controller ─▶ border ─▶ shared memory ─▶ others
                             │ what has come                                │ what has changed
                             └───────────────▶ ring (locked memory) ◀───────┘
                                                 └─▶ service process ─▶ segments on the disk ─▶ tandem record, replay
"""
