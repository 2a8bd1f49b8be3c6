"""The networks' layers, run with little cost a call."""

from __future__ import annotations

from torch import Tensor, nn
from torch.nn.functional import linear, silu


class Mlp(nn.Sequential):
    """Linear layers with SiLU between them.

    For the few rows of a decision, calling each layer as a module takes as long as what it computes.

    Args:
        widths: of the input and of each layer's output.
    """

    def __init__(self, *widths: int) -> None:
        layers: list[nn.Module] = []
        for inputs, outputs in zip(widths, widths[1:], strict=False):
            layers += [nn.Linear(inputs, outputs), nn.SiLU()]
        super().__init__(*layers[:-1])

    def forward(self, rows: Tensor) -> Tensor:
        for layer in self._modules.values():
            if isinstance(layer, nn.Linear):
                rows = linear(rows, layer.weight, layer.bias)
            else:
                rows = silu(rows)
        return rows
