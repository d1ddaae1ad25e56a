"""The nodes of a tree: base classes, and the built-in ones."""

from .action import Action as Action
from .action import Condition as Condition
from .node import Node as Node
from .node import NodeKind as NodeKind
from .test_node import TestNodeConfig as TestNodeConfig
from .tree_node import TreeNode as TreeNode
from .tree_node import behaviour_of as behaviour_of
