"""Layers of a network, compared with numpy."""

import numpy as np
import pytest

from grind_env.kernel.network_layers import linear, logistic_layer, tanh_layer

ROWS, INPUTS, OUTPUTS = 69, 37, 23


@pytest.fixture
def layer() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    return rng.uniform(-3.0, 3.0, (ROWS, INPUTS)), rng.uniform(-2.0, 2.0, (INPUTS, OUTPUTS)), rng.uniform(size=OUTPUTS)


def test_layers_match_numpy(layer):
    values, weights, bias = layer
    sums = linear(values, weights, bias)
    np.testing.assert_allclose(sums, values @ weights + bias, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(tanh_layer(sums), np.tanh(sums), atol=1e-15)
    np.testing.assert_allclose(logistic_layer(sums), 1.0 / (1.0 + np.exp(-sums)), rtol=1e-14)


@pytest.mark.bits
def test_linear_sums_the_inputs_in_order(layer):
    values, weights, bias = layer
    for i, row in enumerate(linear(values, weights, bias)):
        for j, found in enumerate(row.tolist()):
            wanted = float(bias[j])
            for value, weight in zip(values[i].tolist(), weights[:, j].tolist(), strict=True):
                wanted += value * weight
            assert found == wanted


@pytest.mark.bits
@pytest.mark.parametrize("activation", [tanh_layer, logistic_layer])
def test_an_activation_does_not_depend_on_neighbouring_values(activation, layer):
    values = layer[0]
    together = activation(values)
    for i, j in np.ndindex(values.shape):
        assert activation(values[i : i + 1, j : j + 1].copy())[0, 0] == together[i, j]
