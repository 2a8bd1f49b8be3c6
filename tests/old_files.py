"""Files of old versions of the formats, which are read but no longer written."""

from __future__ import annotations

import json

VERSION_2 = b"\n".join(
    json.dumps(row).encode()
    for row in [
        {
            "event": "header",
            "format": "ntp-trace",
            "version": 2,
            "library": "sample",
            "goal": [{"item": "a", "support": "b"}],
            "arguments": [[{"record": "Placement", "item": "a", "support": "b"}]],
            "policy": "learned",
            "model": "m.safetensors",
            "things": [
                {"name": "a", "type": "Block", "size": [0.03, 0.05, 0.09], "traits": [["colour", "red"]]},
                {"name": "b", "type": "Block", "size": [0.05, 0.05, 0.05], "shape": "box", "fixed": False},
            ],
            "demonstration": {
                "file": "a.demo.parquet",
                "frames": 9,
                "calls": {
                    "name": "build",
                    "arguments": [[{"record": "Placement", "item": "a", "support": "b"}]],
                    "scope": [0, 9],
                    "done": True,
                    "children": [
                        {"name": "pick", "arguments": ["a"], "scope": [0, 4], "done": True, "children": []}
                    ],
                },
            },
            "disturbances": {"slips": 0.25, "pushes": 0.0, "noise": 0.0, "clumsiness": 0.0},
        },
        {
            "event": "state",
            "id": 0,
            "positions": {"a": [0, 0, 0.015], "b": [0.2, 0, 0.025]},
            "gripper": [0, 0, 1],
            "closed": False,
            "tipped": {"a": [0.05, 0.09, 0.03]},
        },
        {
            "event": "call",
            "id": 0,
            "parent": -1,
            "kind": "program",
            "name": "build",
            "arguments": [[{"record": "Placement", "item": "a", "support": "b"}]],
            "scope": [0, 9],
            "frame": 0,
            "state": 0,
            "decision": {},
        },
        {
            "event": "call",
            "id": 1,
            "parent": 0,
            "kind": "api",
            "name": "push",
            "arguments": ["a", "left", 0.1],
            "scope": [0, 4],
            "frame": 0,
            "state": 0,
            "decision": {
                "source": "s.ntp:3",
                "end_probability": 0.1,
                "top": [["push", 0.7], ["pick", 0.3]],
                "probability": 0.6,
                "pointers": [[["a", 0.6], ["b", 0.4]]],
                "scopes": [[[0, 4], 0.8], [None, 0.2]],
                "values": [[["left", 1.0]], [[0.1, 1.0]]],
                "seconds": 0.002,
            },
        },
        {
            "event": "return",
            "id": 1,
            "outcome": "grasp failed",
            "frame": 4,
            "planning": 0.25,
            "moving": 0.5,
            "solver": "ik",
            "planner": "straight",
            "evidence": {"width": 0.01},
            "disturbances": ["slip a"],
        },
        {
            "event": "return",
            "id": 0,
            "outcome": "done",
            "frame": 4,
            "state": 0,
            "decision": {"source": "s.ntp:2", "end_probability": 0.9, "probability": 0.9, "seconds": 0.001},
        },
        {
            "event": "end",
            "done": False,
            "reason": "unfinished: nothing that the program knows helps",
            "primitives": 1,
            "success": False,
            "blame": "grasp",
            "verdict": "on(a, b) does not hold",
        },
    ]
)
VERSION_2 += b"\n"
