"""Tiny random DETR and CLIP, and a ResNet-18, in the layout of the published folders."""

from __future__ import annotations

from pathlib import Path

import torch
import transformers
from tokenizers import Tokenizer, models, pre_tokenizers, processors

from models.nets.vision.resnet18 import FrozenResNet18

DETR_LABELS = ("N/A", "cup", "coffee table", "table", "bed")


def resnet(folder: Path, layer_type: str = "basic") -> Path:
    """Save the ResNet-18 with random weights as a classifier, or a small ResNet of bottlenecks."""
    config = FrozenResNet18()._model.config
    if layer_type != "basic":
        config = transformers.ResNetConfig(
            embedding_size=8, hidden_sizes=[16, 16, 16, 16], depths=[1, 1, 1, 1], layer_type=layer_type
        )
    model = transformers.ResNetForImageClassification(config)
    if layer_type == "basic":
        model.resnet.load_state_dict(FrozenResNet18()._model.state_dict())
    model.save_pretrained(folder)
    return folder


def detr(folder: Path, width: int = 256) -> Path:
    """Save a random DETR with one encoder and one decoder layer, 100 queries of ``width``, and five labels."""
    torch.manual_seed(0)
    backbone = transformers.ResNetConfig(
        embedding_size=8, hidden_sizes=[8, 16, 16, 16], depths=[1, 1, 1, 1], out_features=["stage4"]
    )
    config = transformers.DetrConfig(
        backbone_config=backbone, d_model=width, num_queries=100, encoder_layers=1, decoder_layers=1,
        encoder_ffn_dim=32, decoder_ffn_dim=32, encoder_attention_heads=4, decoder_attention_heads=4,
        id2label=dict(enumerate(DETR_LABELS)), label2id={name: k for k, name in enumerate(DETR_LABELS)},
    )  # fmt: skip
    model = transformers.DetrForObjectDetection(config)
    torch.nn.init.normal_(model.class_labels_classifier.weight, std=1.0)  # so that queries find different things
    torch.nn.init.normal_(model.model.query_position_embeddings.weight, std=3.0)
    model.save_pretrained(folder)
    return folder


def clip(folder: Path, width: int = 1024) -> Path:
    """Save a random CLIP text tower that projects to ``width``, with a tokenizer of whole words."""
    tokens = ["<unk>", "<start>", "coffee", "cup", "bed", "table", "<end>"]
    vocab = {token: k for k, token in enumerate(tokens)}
    inner = Tokenizer(models.WordLevel(vocab, unk_token="<unk>"))
    inner.pre_tokenizer = pre_tokenizers.Whitespace()
    marks = [("<start>", vocab["<start>"]), ("<end>", vocab["<end>"])]
    inner.post_processor = processors.TemplateProcessing(single="<start> $A <end>", special_tokens=marks)
    transformers.PreTrainedTokenizerFast(
        tokenizer_object=inner, unk_token="<unk>", bos_token="<start>", eos_token="<end>", pad_token="<end>",
        model_max_length=16,
    ).save_pretrained(folder)  # fmt: skip
    torch.manual_seed(0)
    config = transformers.CLIPTextConfig(
        vocab_size=len(tokens), hidden_size=32, intermediate_size=32, num_hidden_layers=1, num_attention_heads=2,
        max_position_embeddings=16, projection_dim=width, bos_token_id=1, eos_token_id=6, pad_token_id=6,
    )  # fmt: skip
    transformers.CLIPTextModelWithProjection(config).save_pretrained(folder)
    return folder
