"""Learned policies as leaves of trees."""

from bt_manip_policy.is_above import IsAbove as IsAbove
from bt_manip_policy.onnx_policy import OnnxPolicy as OnnxPolicy
from bt_manip_policy.onnx_policy import PolicyError as PolicyError
from bt_manip_policy.run_policy import RunPolicy as RunPolicy
